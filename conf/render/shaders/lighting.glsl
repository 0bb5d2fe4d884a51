// Lights fixed to the viewer, linear RGB; image axes, x right, y up, z towards the viewer. The camera is far away, so
// the direction to the viewer is constant.
const vec3 VIEW = vec3(0.0, 0.0, 1.0);
const vec3 KEY = normalize(vec3(-0.50, 0.55, 0.75));
const vec3 KEY_COLOUR = vec3(1.00, 0.93, 0.84) * 2.05;
const vec3 FILL = normalize(vec3(0.85, 0.05, 0.55));
const vec3 FILL_COLOUR = vec3(0.62, 0.74, 1.00) * 0.30;
const vec3 SKY = vec3(0.70, 0.80, 1.00) * 0.34;
const vec3 GROUND = vec3(0.62, 0.42, 0.34) * 0.20;
const vec3 RIM = normalize(vec3(0.80, 0.45, -0.45));
const vec3 RIM_COLOUR = vec3(0.75, 0.86, 1.00) * 1.5;
const float EXPOSURE = 0.78;

// sRGB to linear by a polynomial, within 0.003 of the standard's curve: pow() is slow on a software renderer.
// Source: C. Taubman, "sRGB approximations for HLSL", 2012.
vec3 to_linear(vec3 c) { return c * (c * (c * 0.305306011 + 0.682171111) + 0.012522878); }

// Tone mapping, in which highlights are compressed instead of clipped, and linear to sRGB, as one function of the square
// root: a rational fit within 0.003 of Taubman's curve after equation 4 of Reinhard et al. 2002 with c (1 + c / 9) /
// (1 + 0.45 c). The render target clamps the result to 0 to 1.
vec4 finish(vec3 linear_light, float alpha) {
    vec3 s = sqrt(max(linear_light * EXPOSURE, 0.0));
    return vec4((s * (s * 0.238748 + 1.439949) - 0.041385) / (s * 0.845501 + 1.0), alpha);
}

vec3 ambient(vec3 n) { return mix(GROUND, SKY, 0.5 + 0.5 * n.y); }

// GGX distribution. Light, viewer and half vector are constant, so the other terms of the microfacet model are too. Source: Walter et al. 2007, equation 33.
float ggx(float n_dot_h, float alpha) {
    float a2 = alpha * alpha;
    float d = n_dot_h * n_dot_h * (a2 - 1.0) + 1.0;
    return a2 / (3.14159265 * d * d);
}

float fresnel(float n_dot_v) {
    float m = 1.0 - n_dot_v;
    float m2 = m * m;
    return m2 * m2 * m;
}
