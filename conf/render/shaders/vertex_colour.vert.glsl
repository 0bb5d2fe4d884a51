uniform mat4 clip;
uniform mat3 rotation;

in vec3 in_position;
in vec3 in_normal;
in vec3 in_colour;

out vec3 normal;
out vec3 tint;

void main() {
    gl_Position = clip * vec4(in_position, 1.0);
    normal = rotation * normalize(in_normal + vec3(1e-12));
    tint = in_colour;
}
