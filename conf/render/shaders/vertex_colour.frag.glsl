in vec3 normal;
in vec3 tint;

out vec4 colour;

// Diffuse light from the upper left, so that the colours stay distinguishable.
void main() {
    vec3 n = normalize(normal);
    float key = clamp(dot(n, vec3(-0.44, 0.48, 0.76)) * 0.5 + 0.5, 0.0, 1.0);
    colour = vec4(tint * (0.18 + 0.92 * key * key), 1.0);
}
