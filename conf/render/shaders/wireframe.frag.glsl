uniform vec3 tint;

in vec3 normal;

out vec4 colour;

void main() {
    float facing = clamp(normalize(normal).z, 0.0, 1.0);
    colour = vec4(tint * (0.35 + 0.65 * facing), 1.0);
}
