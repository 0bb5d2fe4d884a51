#include "lighting.glsl"

uniform sampler2D atlas;
uniform vec3 centre;  // of this eyeball, face axes, cm
uniform float radius;

in vec3 normal;
in vec3 place;
in vec2 uv;

out vec4 colour;

void main() {
    vec3 n = normalize(normal);
    vec3 albedo = to_linear(texture(atlas, uv).rgb);

    // The lids shade the ball: most under the upper one, some in the corners. It stays with the lids while the eye turns.
    vec2 off = (place.xy - centre.xy) / radius;
    float shade = smoothstep(0.62, -0.10, off.y) * smoothstep(1.0, 0.35, abs(off.x)) * 0.8 + 0.2;

    float key = clamp((dot(n, KEY) + 0.5) / 1.5, 0.0, 1.0);
    float fill = clamp(dot(n, FILL) * 0.6 + 0.4, 0.0, 1.0);
    vec3 diffuse = albedo * shade * (KEY_COLOUR * key * 0.8 + FILL_COLOUR * fill + ambient(n));

    // Two catchlights: the key as a small soft disc, the fill as a faint one. The wet film reflects the sky at the rims.
    vec3 r = vec3(2.0 * n.z * n.xy, 2.0 * n.z * n.z - 1.0);
    const vec3 WINDOW = normalize(vec3(-0.40, 0.26, 0.88));  // lower than the key, or the lid would hide it
    float key_light = smoothstep(0.972, 0.988, dot(r, WINDOW));
    float fill_light = smoothstep(0.93, 0.99, dot(r, FILL));
    vec3 wet = vec3(1.0, 0.98, 0.95) * key_light * 1.6 + FILL_COLOUR * fill_light * 0.5;
    float edge = fresnel(clamp(n.z, 0.0, 1.0));
    colour = finish(diffuse + wet * (0.3 + 0.7 * shade) + SKY * (0.03 + 0.3 * edge) * shade, 1.0);
}
