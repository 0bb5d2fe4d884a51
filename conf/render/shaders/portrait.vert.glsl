// A vertex of the photo mesh: its position, its texture coordinates, its alpha.
uniform vec4 frame;          // from image heights to clip coordinates: scale x, scale y, shift x, shift y
uniform float depth;         // of the layer, clip coordinates

in vec2 in_position;         // image heights, x right, y up
in vec2 in_uv;               // of the texture, from its upper left corner
in float in_alpha;

out vec2 uv;
out float alpha;

void main() {
    uv = in_uv;
    alpha = in_alpha;
    gl_Position = vec4(in_position * frame.xy + frame.zw, depth, 1.0);
}
