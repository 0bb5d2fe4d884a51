uniform vec2 size;  // of the framebuffer in pixels

in vec2 in_position;
in vec2 in_uv;
in vec4 in_colour;

out vec2 uv;
out vec4 tint;

void main() {
    uv = in_uv;
    tint = in_colour;
    gl_Position = vec4(in_position / size * vec2(2.0, -2.0) + vec2(-1.0, 1.0), 0.0, 1.0);
}
