// First pass: the canvas as it is; depth 0 marks the edges for the second pass.
#include "compose.glsl"

const float EDGE = 0.05;       // neighbours that differ less are no edge

void main() {
    vec3 here = texture(canvas, at).rgb;
    gl_FragDepth = contrast(around(at), dot(here, LUMA)) > EDGE ? 0.0 : 1.0;
    colour = vec4(here, 1.0);
}
