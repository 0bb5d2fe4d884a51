#include "albedo.glsl"

uniform vec3 centre;  // of this eyeball, face axes, cm
uniform float radius;  // cm

in vec3 normal;
in vec3 position;
in vec2 uv;

out vec4 colour;

void main() {
    vec3 n = normalize(normal);
    vec3 albedo = albedo_at(uv).rgb;

    // Ambient occlusion by the lids, strongest below the upper lid. It depends on the position, not on the eye's rotation.
    vec2 offset = (position.xy - centre.xy) / radius;
    float shade = smoothstep(0.62, -0.10, offset.y) * smoothstep(1.0, 0.35, abs(offset.x)) * 0.8 + 0.2;

    float key = clamp((dot(n, KEY) + 0.5) / 1.5, 0.0, 1.0);
    float fill = clamp(dot(n, FILL) * 0.6 + 0.4, 0.0, 1.0);
    vec3 diffuse = albedo * shade * (KEY_COLOUR * key * 0.8 + FILL_COLOUR * fill + ambient(n));

    // Two catchlights: the key light as a small soft disc, the fill light as a faint one; the sky at grazing angles.
    vec3 r = vec3(2.0 * n.z * n.xy, 2.0 * n.z * n.z - 1.0);
    const vec3 CATCHLIGHT = normalize(vec3(-0.40, 0.26, 0.88));  // lower than the key light, or the lid would cover it
    float key_light = smoothstep(0.972, 0.988, dot(r, CATCHLIGHT));
    float fill_light = smoothstep(0.93, 0.99, dot(r, FILL));
    vec3 wet = vec3(1.0, 0.98, 0.95) * key_light * 1.6 + FILL_COLOUR * fill_light * 0.5;
    float edge = fresnel(clamp(n.z, 0.0, 1.0));
    colour = finish(diffuse + wet * (0.3 + 0.7 * shade) + SKY * (0.03 + 0.3 * edge) * shade, 1.0);
}
