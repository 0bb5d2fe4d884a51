// Shared by the passes that resolve a render target. Green stands for brightness, of which it is the largest part: one
// channel is fetched faster than three. texture() takes two thirds of the time of texelFetch() on a software renderer.
uniform sampler2D image;       // nearest filter, clamped to the edge
uniform vec2 pixel;            // size of a pixel in texture coordinates

in vec2 uv;

out vec4 colour;

float luma(vec2 p) { return texture(image, p).g; }

// Brightness to the north, south, east and west.
vec4 neighbours(vec2 p) {
    vec2 x = vec2(pixel.x, 0.0), y = vec2(0.0, pixel.y);
    return vec4(luma(p + y), luma(p - y), luma(p + x), luma(p - x));
}

float contrast(vec4 nsew, float h) {
    float low = min(min(min(nsew.x, nsew.y), min(nsew.z, nsew.w)), h);
    float high = max(max(max(nsew.x, nsew.y), max(nsew.z, nsew.w)), h);
    return high - low;
}
