#include "albedo.glsl"

in vec3 normal;
in vec2 uv;

out vec4 colour;

// Hair, brows and lashes: one broad highlight; alpha from the texture.
void main() {
    vec4 texel = albedo_at(uv);
    if (texel.a < 0.12) discard;  // almost transparent pixels must not write depth
    vec3 n = normalize(gl_FrontFacing ? normal : -normal);
    vec3 albedo = texel.rgb;
    float key = clamp((dot(n, KEY) + 0.4) / 1.4, 0.0, 1.0);
    const vec3 HALF = normalize(KEY + VIEW);
    vec3 shine = ggx(clamp(dot(n, HALF), 0.0, 1.0), 0.42) * (0.012 + 0.16 * albedo);
    float edge = fresnel(clamp(n.z, 0.0, 1.0));
    vec3 rim = RIM_COLOUR * clamp(dot(n, RIM), 0.0, 1.0) * (0.012 + 0.08 * edge);
    colour = finish(albedo * (KEY_COLOUR * key + ambient(n)) + KEY_COLOUR * shine + rim, texel.a);
}
