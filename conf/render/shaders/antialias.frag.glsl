// Second pass, at edge pixels only: anti-alias. Multisampling takes 2.5 times as long on a software renderer.
// Both ends of the edge are searched for; the distance to the nearer end gives the blend weight of the pixel across
// the edge. Source: Lottes, "FXAA 3.11", NVIDIA 2011, quality variant.
#include "compose.glsl"

const float SUBPIXEL = 0.5;    // blend weight of a single pixel that differs from all neighbours
const int STEPS = 5;
const float DISTANCES[STEPS] = float[](1.0, 2.0, 3.0, 5.0, 12.0);

// Return the length of the edge in the direction of `step`, pixels, and the brightness difference at its end.
float edge_length(vec2 side, vec2 step, vec2 level_tolerance, out float difference) {
    for (int i = 0; i < STEPS; ++i) {
        vec2 q = uv + DISTANCES[i] * step;
        difference = 0.5 * (luma(q) + luma(q + side)) - level_tolerance.x;
        if (abs(difference) >= level_tolerance.y) return DISTANCES[i];
    }
    return DISTANCES[STEPS - 1];
}

void main() {
    vec3 centre = texture(image, uv).rgb;
    float h = centre.g;
    vec4 nsew = neighbours(uv);
    vec2 across_to = vec2(pixel.x, -pixel.y);
    float ne = luma(uv + pixel), nw = luma(uv - across_to), se = luma(uv + across_to), sw = luma(uv - pixel);
    float along_x = abs(nw + sw - 2.0 * nsew.w) + 2.0 * abs(nsew.x + nsew.y - 2.0 * h) + abs(ne + se - 2.0 * nsew.z);
    float along_y = abs(nw + ne - 2.0 * nsew.x) + 2.0 * abs(nsew.z + nsew.w - 2.0 * h) + abs(sw + se - 2.0 * nsew.y);
    bool horizontal = along_x >= along_y;
    vec2 sides = horizontal ? nsew.xy : nsew.zw;
    bool first = abs(sides.x - h) >= abs(sides.y - h);
    float across = first ? sides.x : sides.y;
    vec2 x = vec2(pixel.x, 0.0), y = vec2(0.0, pixel.y);
    vec2 side = (first ? 1.0 : -1.0) * (horizontal ? y : x);
    vec2 step = horizontal ? x : y;

    vec2 level_tolerance = vec2(0.5 * (across + h), 0.25 * abs(across - h));
    float end_plus, end_minus;
    float plus = edge_length(side, step, level_tolerance, end_plus);
    float minus = edge_length(side, -step, level_tolerance, end_minus);
    float nearer_end = plus < minus ? end_plus : end_minus;
    float weight = (nearer_end < 0.0) != (h < level_tolerance.x) ? 0.5 - min(plus, minus) / (plus + minus) : 0.0;

    float mean = (2.0 * (nsew.x + nsew.y + nsew.z + nsew.w) + ne + nw + se + sw) / 12.0;
    float isolation = smoothstep(0.0, 1.0, clamp(abs(mean - h) / contrast(nsew, h), 0.0, 1.0));
    colour = vec4(mix(centre, texture(image, uv + side).rgb, max(weight, isolation * isolation * SUBPIXEL)), 1.0);
}
