// Between the lips of a photograph whose mouth was shut, while there is no patch of an open one: dark, as mouths are.
uniform vec3 dark;
uniform float opacity;

in vec2 uv;
in float share;

out vec4 colour;

void main() {
    colour = vec4(dark, opacity);
}
