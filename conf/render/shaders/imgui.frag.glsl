uniform sampler2D glyphs;

in vec2 uv;
in vec4 ink;

out vec4 colour;

void main() { colour = ink * texture(glyphs, uv); }
