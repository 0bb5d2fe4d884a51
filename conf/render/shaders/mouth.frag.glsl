#include "albedo.glsl"

uniform vec3 centre;  // between the inner lips, face axes, cm
uniform float opening;  // from lip to lip in the middle, cm; 0 for a closed mouth

in vec3 normal;
in vec3 position;
in vec2 uv;

out vec4 colour;

const vec3 BOUNCE = vec3(0.42, 0.27, 0.22);  // indirect light from the surrounding tissue

// Teeth, tongue and the inside of the mouth: glossy, and darker with the depth behind the lips. Little light gets through
// a slit: lips that do not quite touch show a dark line and no teeth.
void main() {
    vec3 n = normalize(normal);
    vec3 albedo = albedo_at(uv).rgb;
    float depth = centre.z - position.z;
    float light = mix(0.04, 0.75, exp2(-max(depth, 0.0) * 0.75)) * smoothstep(3.2, 0.8, abs(position.x - centre.x));
    light *= 0.12 + 0.88 * smoothstep(0.03, 0.18, opening);

    float key = clamp((dot(n, KEY) + 0.6) / 1.6, 0.0, 1.0);
    const vec3 HALF = normalize(KEY + VIEW);
    float shine = ggx(clamp(dot(n, HALF), 0.0, 1.0), 0.16) * 0.04;
    colour = finish(light * (albedo * (KEY_COLOUR * key + BOUNCE) + KEY_COLOUR * shine), 1.0);
}
