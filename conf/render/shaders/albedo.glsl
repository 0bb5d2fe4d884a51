// Colour of the surface. Materials with a colour of their own, and vertex colours, need the constant TINTED.
#include "lighting.glsl"

const bool TINTED = false;

uniform sampler2D atlas;
uniform vec4 tint;       // linear colour and alpha of the material

in vec3 vertex_colour;   // sRGB

vec4 albedo_at(vec2 at) {
    vec4 texel = texture(atlas, at);
    vec3 linear_colour = to_linear(texel.rgb);
    return TINTED ? vec4(linear_colour * tint.rgb * to_linear(vertex_colour), texel.a * tint.a)
                  : vec4(linear_colour, texel.a);
}
