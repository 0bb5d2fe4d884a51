uniform mat4 clip;
uniform mat3 turn;

in vec3 in_position;
in vec3 in_normal;
in vec2 in_uv;

out vec3 normal;
out vec3 place;
out vec2 uv;

void main() {
    gl_Position = clip * vec4(in_position, 1.0);
    normal = turn * normalize(in_normal + vec3(1e-12));
    place = in_position;
    uv = in_uv;
}
