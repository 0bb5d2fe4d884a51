uniform mat4 clip;
uniform sampler2D depth;     // of the face's picture
uniform float side;          // of a mark in pixels
uniform ivec2 grid;          // columns and rows of marks in the atlas

in vec3 in_position;

flat out vec2 cell;          // lower left corner of this mark in the atlas

const float BIAS = 0.0035;   // of the depth range: a point may lie 4 mm under the surface and still be seen

void main() {
    gl_Position = clip * vec4(in_position, 1.0);
    vec3 at = gl_Position.xyz / gl_Position.w * 0.5 + 0.5;
    ivec2 size = textureSize(depth, 0);
    float surface = texelFetch(depth, clamp(ivec2(at.xy * vec2(size)), ivec2(0), size - 1), 0).r;
    if (at.z > surface + BIAS) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // behind the face: out of the picture
    gl_PointSize = side;
    cell = vec2(gl_VertexID % grid.x, grid.y - 1 - gl_VertexID / grid.x) / vec2(grid);
}
