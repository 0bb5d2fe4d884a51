// Rectangles of an image that covers the viewport.
in vec2 in_position;  // 0 to 1, from the lower left corner

out vec2 uv;

void main() {
    uv = in_position;
    gl_Position = vec4(uv * 2.0 - 1.0, 0.0, 1.0);
}
