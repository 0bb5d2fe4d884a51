#include "albedo.glsl"
#include "furrows.glsl"

uniform mat3 rotation;

in vec3 normal;
in vec2 uv;
in float light_visibility;

out vec4 colour;

// Wrap lighting per channel: red is scattered farthest, which gives skin its reddish terminator.
// Source: Green, "Real-time approximations to subsurface scattering", GPU Gems 2004.
const vec3 WRAP = vec3(0.42, 0.22, 0.16);
const float F0 = 0.028;

void main() {
    vec3 n = normalize(normal);
    vec3 albedo = albedo_at(uv).rgb;
    if (FURROWED) {
        vec3 furrow = furrows_at(forehead);
        n = normalize(n - furrow.x * rotation[0] - furrow.y * rotation[1]);
        albedo *= 1.0 - 0.4 * furrow.z;
    }

    vec3 wrapped = clamp((dot(n, KEY) + WRAP) / (1.0 + WRAP), 0.0, 1.0);
    float visible = light_visibility;
    vec3 reached = vec3(visible * (1.3 - 0.3 * visible), visible, visible);  // red light is scattered into shadows
    float fill = clamp(dot(n, FILL) * 0.6 + 0.4, 0.0, 1.0);
    vec3 diffuse = albedo * (KEY_COLOUR * wrapped * wrapped * reached + FILL_COLOUR * fill + ambient(n));

    const vec3 HALF = normalize(KEY + VIEW);
    float n_dot_h = clamp(dot(n, HALF), 0.0, 1.0);
    // Lips, the reddest skin, are glossy.
    float wet = smoothstep(0.10, 0.30, albedo.r - 1.25 * albedo.g);
    float lobes = (0.75 + wet) * ggx(n_dot_h, mix(0.32, 0.22, wet)) + 0.25 * ggx(n_dot_h, 0.14);
    float edge = fresnel(clamp(n.z, 0.0, 1.0));
    vec3 shine = KEY_COLOUR * (visible * F0 * lobes * clamp(dot(n, KEY) * 1.5, 0.0, 1.0) * 0.75);
    vec3 rim = RIM_COLOUR * (clamp(dot(n, RIM), 0.0, 1.0) * (0.15 + edge)) * (0.25 + albedo);
    colour = finish(diffuse + shine + rim + edge * 0.12 * SKY, 1.0);
}
