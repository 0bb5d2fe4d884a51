// First pass: copy the image; write depth 0 at edges for the second pass.
#include "compose.glsl"

const float EDGE_CONTRAST = 0.0625;  // smallest brightness difference of an edge; Lottes: "visible limit"

void main() {
    vec3 centre = texture(image, uv).rgb;
    gl_FragDepth = contrast(neighbours(uv), centre.g) > EDGE_CONTRAST ? 0.0 : 1.0;
    colour = vec4(centre, 1.0);
}
