// The mouth opening of a photo with a closed mouth, while no patch of an open mouth has arrived: a dark colour.
uniform vec3 dark;
uniform float opacity;

in vec2 uv;
in float alpha;

out vec4 colour;

void main() {
    colour = vec4(dark, opacity);
}
