// A vertex of the photograph's mesh: where it goes, where it lies in the picture that is laid on, how much of that shows.
uniform vec4 frame;          // from picture heights to clip coordinates: scale x, scale y, shift x, shift y

in vec2 in_place;            // picture heights, x right, y up
in vec2 in_uv;               // of the texture, from its upper left corner
in float in_share;

out vec2 uv;
out float share;

void main() {
    uv = in_uv;
    share = in_share;
    gl_Position = vec4(in_place * frame.xy + frame.zw, 0.0, 1.0);
}
