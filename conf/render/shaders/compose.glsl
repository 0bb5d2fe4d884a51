// What the two passes that put the canvas on the screen share: its pixels and their brightness. They are fetched by
// texture(): without a GPU that takes two thirds of the time of texelFetch().
uniform sampler2D canvas;      // looked up without filtering, its border goes on outside
uniform vec2 pixel;            // size of a pixel, of the canvas

in vec2 at;

out vec4 colour;

const vec3 LUMA = vec3(0.299, 0.587, 0.114);

float luma(vec2 p) { return dot(texture(canvas, p).rgb, LUMA); }

// Brightness to the north, south, east and west.
vec4 around(vec2 p) {
    vec2 x = vec2(pixel.x, 0.0), y = vec2(0.0, pixel.y);
    return vec4(luma(p + y), luma(p - y), luma(p + x), luma(p - x));
}

float contrast(vec4 nsew, float h) {
    float low = min(min(min(nsew.x, nsew.y), min(nsew.z, nsew.w)), h);
    float high = max(max(max(nsew.x, nsew.y), max(nsew.z, nsew.w)), h);
    return high - low;
}
