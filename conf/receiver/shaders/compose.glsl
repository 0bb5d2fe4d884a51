// What the two passes that put the canvas on the screen share: its pixels and their brightness.
uniform sampler2D canvas;
uniform ivec2 origin;          // lower left corner of the part of the framebuffer that is drawn

out vec4 colour;

const vec3 LUMA = vec3(0.299, 0.587, 0.114);

ivec2 last;

ivec2 find_pixel() {
    last = textureSize(canvas, 0) - 1;
    return ivec2(gl_FragCoord.xy) - origin;
}

vec3 at(ivec2 p) { return texelFetch(canvas, clamp(p, ivec2(0), last), 0).rgb; }

float luma(ivec2 p) { return dot(at(p), LUMA); }

// Brightness to the north, south, east and west.
vec4 around(ivec2 p) {
    return vec4(luma(p + ivec2(0, 1)), luma(p - ivec2(0, 1)), luma(p + ivec2(1, 0)), luma(p - ivec2(1, 0)));
}

float contrast(vec4 nsew, float h) {
    float low = min(min(min(nsew.x, nsew.y), min(nsew.z, nsew.w)), h);
    float high = max(max(max(nsew.x, nsew.y), max(nsew.z, nsew.w)), h);
    return high - low;
}
