#include "lighting.glsl"

uniform mat4 clip;
uniform mat3 rotation;
uniform mat4 light;              // from face axes to texture coordinates of the shadow map
uniform sampler2DShadow shadow;  // shadow map

in vec3 in_position;
in vec3 in_normal;
in vec2 in_uv;
in vec3 in_colour;  // sRGB
in vec2 in_forehead;  // cm, see furrows.glsl

out vec3 normal;
out vec2 uv;
out vec3 vertex_colour;
out vec2 forehead;
out float light_visibility;      // fraction of the key light that reaches the vertex, 0 to 1

const bool FURROWED = false;
const float LIFT_CM = 0.35;      // offset along the normal against self-shadowing
const float SOFT = 0.030;        // radius of a shadow's soft edge, texture coordinates
const vec2 DISC[12] = vec2[](
    vec2(-0.326, -0.406), vec2(-0.840, -0.074), vec2(-0.696, 0.457), vec2(-0.203, 0.621), vec2(0.962, -0.195),
    vec2(0.473, -0.480), vec2(0.519, 0.767), vec2(0.185, -0.893), vec2(0.507, 0.064), vec2(0.896, 0.412),
    vec2(-0.322, -0.933), vec2(-0.792, -0.598));

// Percentage-closer filtering. A shadow looked up per vertex and interpolated is soft and takes a tenth of the time of
// one looked up per pixel.
float visibility(vec3 outwards, float facing) {
    vec3 at = (light * vec4(in_position + LIFT_CM * outwards, 1.0)).xyz;
    float sum = 0.0;
    for (int i = 0; i < 12; ++i) sum += texture(shadow, vec3(at.xy + SOFT * DISC[i], at.z));
    return mix(1.0, sum / 12.0, smoothstep(0.05, 0.45, facing));  // surfaces that face away from the light are dark already
}

void main() {
    vec3 outwards = normalize(in_normal + vec3(1e-12));
    gl_Position = clip * vec4(in_position, 1.0);
    normal = rotation * outwards;
    uv = in_uv;
    vertex_colour = in_colour;
    forehead = FURROWED ? in_forehead : vec2(0.0);
    light_visibility = visibility(outwards, dot(normal, KEY));
}
