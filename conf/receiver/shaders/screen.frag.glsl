uniform sampler2D scene;       // the face; alpha is 0 where nothing was drawn
uniform sampler2D background;
uniform ivec2 origin;          // lower left corner of the part of the framebuffer that is drawn

out vec4 colour;

const vec3 LUMA = vec3(0.299, 0.587, 0.114);
const float CONTRAST = 0.06;   // neighbours that differ less are no edge

vec3 behind;
ivec2 last;

vec3 at(ivec2 p) {
    vec4 texel = texelFetch(scene, clamp(p, ivec2(0), last), 0);
    return texel.a > 0.0 ? texel.rgb : behind;
}

// The face over the background, edges smoothed along their direction: multisampling costs 2.5 times as much without a
// GPU. Source: Lottes, "FXAA", NVIDIA 2009, the small variant.
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy) - origin;
    last = textureSize(scene, 0) - 1;
    behind = texelFetch(background, p, 0).rgb;
    vec3 here = at(p);
    vec3 north = at(p + ivec2(0, 1)), south = at(p - ivec2(0, 1));
    vec3 east = at(p + ivec2(1, 0)), west = at(p - ivec2(1, 0));
    float h = dot(here, LUMA);
    vec4 around = vec4(dot(north, LUMA), dot(south, LUMA), dot(east, LUMA), dot(west, LUMA));
    float low = min(min(min(around.x, around.y), min(around.z, around.w)), h);
    float high = max(max(max(around.x, around.y), max(around.z, around.w)), h);
    colour = vec4(here, 1.0);
    if (high - low > CONTRAST) {
        // Across a horizontal edge the vertical second difference is the larger one.
        float across_y = abs(around.x + around.y - 2.0 * h);
        float across_x = abs(around.z + around.w - 2.0 * h);
        vec3 side = across_y >= across_x
            ? (abs(around.x - h) >= abs(around.y - h) ? north : south)
            : (abs(around.z - h) >= abs(around.w - h) ? east : west);
        float mean = (around.x + around.y + around.z + around.w) * 0.25;
        float share = clamp(abs(mean - h) / (high - low), 0.0, 1.0);
        colour.rgb = mix(here, side, share * share * (3.0 - 2.0 * share) * 0.75);
    }
}
