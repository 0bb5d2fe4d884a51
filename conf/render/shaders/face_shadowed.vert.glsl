#include "lighting.glsl"

uniform mat4 clip;
uniform mat3 turn;
uniform mat4 lamp;               // to the lamp's picture, 0 to 1
uniform sampler2DShadow shadow;  // the lamp's picture

in vec3 in_position;
in vec3 in_normal;
in vec2 in_uv;

out vec3 normal;
out vec2 uv;
out float open;                  // the share of the lamp that is seen from here

const float LIFT_CM = 0.35;      // off the skin, so that no face shadows itself
const float SOFT = 0.030;        // radius of a shadow's edge, of the lamp's picture
const vec2 DISC[12] = vec2[](
    vec2(-0.326, -0.406), vec2(-0.840, -0.074), vec2(-0.696, 0.457), vec2(-0.203, 0.621), vec2(0.962, -0.195),
    vec2(0.473, -0.480), vec2(0.519, 0.767), vec2(0.185, -0.893), vec2(0.507, 0.064), vec2(0.896, 0.412),
    vec2(-0.322, -0.933), vec2(-0.792, -0.598));

// For what lies in the key light's shadow. A shadow looked up at the vertices and spread over the triangles is soft, and a tenth of the work of one looked up at
// every pixel.
float seen(vec3 outwards, float facing) {
    vec3 at = (lamp * vec4(in_position + LIFT_CM * outwards, 1.0)).xyz;
    float sum = 0.0;
    for (int i = 0; i < 12; ++i) sum += texture(shadow, vec3(at.xy + SOFT * DISC[i], at.z));
    return mix(1.0, sum / 12.0, smoothstep(0.05, 0.45, facing));  // where the skin turns away it is dark anyhow
}

void main() {
    vec3 outwards = normalize(in_normal + vec3(1e-12));
    gl_Position = clip * vec4(in_position, 1.0);
    normal = turn * outwards;
    uv = in_uv;
    open = seen(outwards, dot(normal, KEY));
}
