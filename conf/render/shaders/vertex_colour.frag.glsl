in vec3 normal;
in vec3 tint;

out vec4 colour;

// Plain light from the viewer's upper left: the colours are to be told apart.
void main() {
    vec3 n = normalize(normal);
    float key = clamp(dot(n, vec3(-0.44, 0.48, 0.76)) * 0.5 + 0.5, 0.0, 1.0);
    colour = vec4(tint * (0.18 + 0.92 * key * key), 1.0);
}
