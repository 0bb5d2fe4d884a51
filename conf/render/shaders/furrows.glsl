// Furrows of the skin, between the brows and across the forehead. Parts of the mesh without any leave FURROWED false.
const bool FURROWED = false;

in vec2 forehead;      // cm to the left of the middle between the inner brows of the neutral face, and up from it

uniform vec2 furrows;  // depth between the brows, and across the forehead, 0 to 1

const float SLOPE = 1.1;  // of the sides of a furrow, at most, as a tangent

// A furrow whose cross-section is a bell: x its slope across for a unit distance from its middle in widths, y its depth.
vec2 groove(float across) {
    float depth = exp(-across * across);
    return vec2(1.166 * SLOPE * across * depth, depth);
}

// The slope of the skin to the subject's left and up, and how dark the furrow is.
vec3 furrows_at(vec2 p) {
    float side = abs(p.x);

    // Two lines from the heads of the brows upwards, a little apart.
    float length_of = smoothstep(-1.2, -0.4, p.y) * (1.0 - smoothstep(0.2, 1.5, p.y)) * furrows.x;
    vec2 line = groove((side - 0.56 - 0.12 * p.y) / 0.23) * length_of;
    vec3 result = vec3(sign(p.x) * line.x, 0.0, line.y);

    // Three lines across, lower at the sides.
    float height = p.y - 1.3 + 0.031 * p.x * p.x;
    float nearest = clamp(floor(height / 0.92 + 0.5), 0.0, 2.0) * 0.92;
    float width_of = (1.0 - smoothstep(2.4, 4.3, side)) * furrows.y;
    vec2 across = groove((height - nearest) / 0.15) * width_of;
    return result + vec3(0.0, across.x, across.y);
}
