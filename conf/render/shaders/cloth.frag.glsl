#include "albedo.glsl"

in vec3 normal;
in vec2 uv;
in float light_visibility;

out vec4 colour;

// Cloth: diffuse only, brighter at grazing angles like a fuzzy surface.
void main() {
    vec3 n = normalize(normal);
    vec3 albedo = albedo_at(uv).rgb;
    float key = clamp((dot(n, KEY) + 0.25) / 1.25, 0.0, 1.0) * light_visibility;
    float fill = clamp(dot(n, FILL) * 0.6 + 0.4, 0.0, 1.0);
    float fuzz = 1.0 - clamp(n.z, 0.0, 1.0);
    vec3 light = KEY_COLOUR * key + FILL_COLOUR * fill + ambient(n);
    colour = finish(albedo * light * (1.0 + fuzz * fuzz), 1.0);
}
