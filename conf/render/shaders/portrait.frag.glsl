// The photograph, its background or a patch, seen through the mesh.
uniform sampler2D picture;
uniform float opacity;
uniform float fade;          // width of a patch's border over which it fades, in texture coordinates; 0 for none

in vec2 uv;
in float share;

out vec4 colour;

void main() {
    vec4 texel = texture(picture, uv);
    vec2 inside = min(uv, 1.0 - uv);
    float border = fade > 0.0 ? smoothstep(0.0, fade, min(inside.x, inside.y)) : 1.0;
    colour = vec4(texel.rgb, texel.a * share * opacity * border);
}
