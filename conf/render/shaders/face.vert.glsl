uniform mat4 clip;
uniform mat3 rotation;

in vec3 in_position;
in vec3 in_normal;
in vec2 in_uv;
in vec3 in_colour;  // sRGB

out vec3 normal;
out vec3 position;
out vec2 uv;
out vec3 vertex_colour;

void main() {
    gl_Position = clip * vec4(in_position, 1.0);
    normal = rotation * normalize(in_normal + vec3(1e-12));
    position = in_position;
    uv = in_uv;
    vertex_colour = in_colour;
}
