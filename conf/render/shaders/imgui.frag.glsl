uniform sampler2D glyphs;

in vec2 uv;
in vec4 tint;

out vec4 colour;

void main() { colour = tint * texture(glyphs, uv); }
