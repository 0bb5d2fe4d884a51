uniform mat4 clip;
uniform sampler2D depth;     // of the image of the face
uniform float side;          // of a marker, pixels
uniform ivec2 grid;          // columns and rows of the atlas

in vec3 in_position;

flat out vec2 cell;          // lower left corner of this marker's cell in the atlas

const float BIAS = 0.0035;   // of the depth range, 4 mm: a point at most this far below the surface is visible

void main() {
    gl_Position = clip * vec4(in_position, 1.0);
    vec3 at = gl_Position.xyz / gl_Position.w * 0.5 + 0.5;
    ivec2 size = textureSize(depth, 0);
    float surface = texelFetch(depth, clamp(ivec2(at.xy * vec2(size)), ivec2(0), size - 1), 0).r;
    if (at.z > surface + BIAS) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // hidden: move it outside the clip volume
    gl_PointSize = side;
    cell = vec2(gl_VertexID % grid.x, grid.y - 1 - gl_VertexID / grid.x) / vec2(grid);
}
