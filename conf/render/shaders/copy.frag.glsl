// Copy an image, enlarged if the viewport is larger and its filter is linear.
uniform sampler2D image;

in vec2 uv;

out vec4 colour;

void main() { colour = texture(image, uv); }
