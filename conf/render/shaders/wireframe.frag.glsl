uniform vec3 ink;

in vec3 normal;

out vec4 colour;

void main() {
    float facing = clamp(normalize(normal).z, 0.0, 1.0);
    colour = vec4(ink * (0.35 + 0.65 * facing), 1.0);
}
