// One triangle that covers the picture.
out vec2 at;  // where a pixel is in the picture: 0 to 1, from the lower left corner

void main() {
    at = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(at * 2.0 - 1.0, 0.0, 1.0);
}
