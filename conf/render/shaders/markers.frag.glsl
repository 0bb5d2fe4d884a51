uniform sampler2D labels;
uniform ivec2 grid;

flat in vec2 cell;

out vec4 colour;

void main() {
    vec2 position = vec2(gl_PointCoord.x, 1.0 - gl_PointCoord.y);
    colour = texture(labels, cell + position / vec2(grid));
    if (colour.a < 0.02) discard;
}
