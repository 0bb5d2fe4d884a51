// One triangle that covers the viewport.
out vec2 uv;  // 0 to 1, from the lower left corner

void main() {
    uv = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
    gl_Position = vec4(uv * 2.0 - 1.0, 0.0, 1.0);
}
