// Second pass, at the edges only: smooth them. Multisampling costs 2.5 times as much without a GPU.
// The ends of the edge are looked for on both sides; how near the nearer end is says how much of the pixel across the
// edge belongs here. Source: Lottes, "FXAA 3.11", NVIDIA 2011, the quality variant.
#include "compose.glsl"

const float SUBPIXEL = 0.5;    // how much of a lone pixel is taken away
const int STEPS = 8;
const float REACH[STEPS] = float[](1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0);

// How far along the edge, in the direction of step, the edge goes on; sets `beyond` to what is found at its end.
float reach(vec2 side, vec2 step, vec2 level_slack, out float beyond) {
    for (int i = 0; i < STEPS; ++i) {
        vec2 q = at + REACH[i] * step;
        beyond = 0.5 * (luma(q) + luma(q + side)) - level_slack.x;
        if (abs(beyond) >= level_slack.y) return REACH[i];
    }
    return REACH[STEPS - 1];
}

void main() {
    vec3 here = texture(canvas, at).rgb;
    float h = dot(here, LUMA);
    vec4 nsew = around(at);
    vec2 across_to = vec2(pixel.x, -pixel.y);
    float ne = luma(at + pixel), nw = luma(at - across_to), se = luma(at + across_to), sw = luma(at - pixel);
    float along_x = abs(nw + sw - 2.0 * nsew.w) + 2.0 * abs(nsew.x + nsew.y - 2.0 * h) + abs(ne + se - 2.0 * nsew.z);
    float along_y = abs(nw + ne - 2.0 * nsew.x) + 2.0 * abs(nsew.z + nsew.w - 2.0 * h) + abs(sw + se - 2.0 * nsew.y);
    bool horizontal = along_x >= along_y;
    vec2 sides = horizontal ? nsew.xy : nsew.zw;
    bool first = abs(sides.x - h) >= abs(sides.y - h);
    float across = first ? sides.x : sides.y;
    vec2 x = vec2(pixel.x, 0.0), y = vec2(0.0, pixel.y);
    vec2 side = (first ? 1.0 : -1.0) * (horizontal ? y : x);
    vec2 step = horizontal ? x : y;

    vec2 level_slack = vec2(0.5 * (across + h), 0.25 * abs(across - h));
    float end_plus, end_minus;
    float plus = reach(side, step, level_slack, end_plus);
    float minus = reach(side, -step, level_slack, end_minus);
    float nearer_end = plus < minus ? end_plus : end_minus;
    float share = (nearer_end < 0.0) != (h < level_slack.x) ? 0.5 - min(plus, minus) / (plus + minus) : 0.0;

    float mean = (2.0 * (nsew.x + nsew.y + nsew.z + nsew.w) + ne + nw + se + sw) / 12.0;
    float lone = smoothstep(0.0, 1.0, clamp(abs(mean - h) / contrast(nsew, h), 0.0, 1.0));
    colour = vec4(mix(here, texture(canvas, at + side).rgb, max(share, lone * lone * SUBPIXEL)), 1.0);
}
