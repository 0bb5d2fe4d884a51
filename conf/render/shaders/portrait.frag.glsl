// The photo, its background or a patch, mapped onto the mesh.
uniform sampler2D image;
uniform float opacity;
uniform float fade;          // width of a patch's soft border, texture coordinates; 0 for none

in vec2 uv;
in float alpha;

out vec4 colour;

void main() {
    vec4 texel = texture(image, uv);
    vec2 border_distance = min(uv, 1.0 - uv);
    float border = fade > 0.0 ? smoothstep(0.0, fade, min(border_distance.x, border_distance.y)) : 1.0;
    colour = vec4(texel.rgb, texel.a * alpha * opacity * border);
}
