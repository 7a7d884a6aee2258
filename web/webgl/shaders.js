/**
 * The vertex and fragment shaders, with variants selected by `#define`.
 *
 * - `NORMALS`: vertices have normals; otherwise triangles are flat-shaded.
 * - `SKIN`: joints move the vertices.
 * - `MORPH`: morph targets move the vertices, from the texture of morphs.js.
 * - `PULL`: corners are fetched from the textures of pulled.js, per triangle.
 * @module
 */

const HEAD = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
`;

export const VERTEX = `
uniform mat4 world, viewProjection;
uniform mat3 normalMatrix;
out vec3 place;
#ifdef SKIN
uniform sampler2D joints;
mat4 skin(vec4 numbers, vec4 weights) {
  mat4 sum = mat4(0);
  for (int i = 0; i < 4; i++) {
    int row = int(numbers[i] + 0.5);
    if (weights[i] > 0.0) sum += weights[i] * mat4(texelFetch(joints, ivec2(0, row), 0), texelFetch(joints, ivec2(1, row), 0), texelFetch(joints, ivec2(2, row), 0), texelFetch(joints, ivec2(3, row), 0));
  }
  return sum / max(dot(weights, vec4(1)), 1e-6);
}
#endif
#ifdef MORPH
uniform sampler2D deltas;
uniform ivec4 slots;
uniform ivec2 targetSize;
uniform int addedCount;
uniform vec2 added[64];
vec4 delta(int slot, int vertex) {
  vec4 sum = vec4(0);
  if (slot < 0) return sum;
  for (int i = 0; i < addedCount; i++) {
    int k = (int(added[i].x) * targetSize.x + slot) * targetSize.y + vertex;
    sum += added[i].y * texelFetch(deltas, ivec2(k & 2047, k >> 11), 0);
  }
  return sum;
}
#endif
#ifdef PULL
uniform usampler2D indices;
uniform sampler2D positions, jointNumbers, jointWeights;
uniform int topology;
flat out uint strip;
out vec3 corner;
ivec2 at(uint k) { return ivec2(k & 2047u, k >> 11); }
void main() {
  int triangle = gl_VertexID / 3;
  int which = gl_VertexID % 3;
  uint first = uint(topology == 4 ? 3 * triangle : topology == 6 ? 0 : triangle);
  uint next = uint(topology == 4 ? 3 * triangle : triangle);
  uvec2 a = texelFetch(indices, at(first), 0).xy, b = texelFetch(indices, at(next + 1u), 0).xy, c = texelFetch(indices, at(next + 2u), 0).xy;
  corner = vec3(which == 0, which == 1, which == 2);
  strip = topology == 5 ? a.y : first;
  place = vec3(0);
  gl_Position = vec4(2, 2, 2, 1);
  if (a.x == ~0u || b.x == ~0u || c.x == ~0u) return;
  if (topology == 5 && ((uint(triangle) - a.y) & 1u) == 1u) { uvec2 swap = b; b = c; c = swap; }
  uint number = which == 0 ? a.x : which == 1 ? b.x : c.x;
  ivec2 vertex = at(number);
  vec4 position = vec4(texelFetch(positions, vertex, 0).xyz, 1);
#ifdef MORPH
  position.xyz += delta(slots.x, int(number)).xyz;
#endif
#ifdef SKIN
  position = skin(texelFetch(jointNumbers, vertex, 0), texelFetch(jointWeights, vertex, 0)) * position;
#endif
#else
layout(location = 0) in vec3 POSITION;
layout(location = 1) in vec3 NORMAL;
layout(location = 2) in vec2 TEXCOORD_0;
layout(location = 3) in vec2 TEXCOORD_1;
layout(location = 4) in vec4 COLOR_0;
layout(location = 5) in vec4 JOINTS_0;
layout(location = 6) in vec4 WEIGHTS_0;
out vec3 normal;
out vec4 uvs, color;
void main() {
  vec4 position = vec4(POSITION, 1);
  vec3 n = NORMAL;
  uvs = vec4(TEXCOORD_0, TEXCOORD_1);
  color = COLOR_0;
#ifdef MORPH
  position.xyz += delta(slots.x, gl_VertexID).xyz;
  n += delta(slots.y, gl_VertexID).xyz;
  uvs.xy += delta(slots.z, gl_VertexID).xy;
  color = clamp(color + delta(slots.w, gl_VertexID), 0.0, 1.0);
#endif
#ifdef SKIN
  mat4 bent = skin(JOINTS_0, WEIGHTS_0);
  position = bent * position;
  n = mat3(bent) * n;
#endif
  normal = normalMatrix * n;
  gl_PointSize = 3.0;
#endif
  position = world * position;
  place = position.xyz;
  gl_Position = viewProjection * position;
}`;

export const FRAGMENT = `
in vec3 place;
uniform vec3 eye, keyLight;
uniform int mode;
out vec4 result;

vec3 environment(vec3 d, float roughness) {
  float blur = 0.15 + 0.85 * roughness;
  vec3 sides = mix(vec3(0.20, 0.19, 0.18), vec3(0.74, 0.77, 0.82), smoothstep(-blur, blur, d.y));
  float panel = smoothstep(0.9 - 0.8 * blur, 1.0, dot(d, keyLight));
  return sides + 0.5 * panel * (1.0 - 0.7 * roughness);
}

// Cosines of unit vectors can slightly exceed 1, and powers of negative numbers are undefined.
float fresnelPower(float cosine) { return pow(max(1.0 - cosine, 0.0), 5.0); }

vec3 lit(vec3 base, float metallic, float roughness, vec3 n, float open) {
  vec3 v = normalize(eye - place);
  float nv = max(dot(n, v), 1e-3);
  vec3 f0 = mix(vec3(0.04), base, metallic);
  vec3 diffuse = base * (1.0 - metallic);
  vec3 sum = vec3(0);
  // A key light from above and beside the viewer, and a weak light from the viewer.
  for (int i = 0; i < 2; i++) {
    vec3 l = i == 0 ? keyLight : v;
    float nl = max(dot(n, l), 0.0);
    vec3 h = normalize(l + v);
    float a = max(roughness * roughness, 0.003), a2 = a * a;
    float nh = max(dot(n, h), 0.0), d = nh * nh * (a2 - 1.0) + 1.0;
    float k = (roughness + 1.0) * (roughness + 1.0) / 8.0;
    float shine = a2 / (d * d) / (4.0 * (nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
    vec3 fresnel = f0 + (1.0 - f0) * fresnelPower(max(dot(h, v), 0.0));
    sum += (diffuse + fresnel * min(shine, 8.0)) * nl * (i == 0 ? 0.85 : 0.2);
  }
  vec3 fresnel = f0 + (max(vec3(1.0 - roughness), f0) - f0) * fresnelPower(nv);
  sum += open * (diffuse * environment(n, 1.0) * 0.5 + fresnel * environment(reflect(-v, n), roughness));
  return sum;
}

vec3 display(vec3 c) {
  c = mix(c, 1.0 - exp(0.6 - c) * 0.4, step(0.6, c));
  return mix(12.92 * c, 1.055 * pow(max(c, 0.0), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

#ifdef PULL
flat in uint strip;
in vec3 corner;
uniform vec3 lineColor;
vec3 hue(float h) { return clamp(abs(fract(h + vec3(0, 2, 1) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0); }
void main() {
  vec3 n = normalize(cross(dFdx(place), dFdy(place)));
  if (mode == 3) {
    uint x = (strip + 1u) * 2654435761u;
    x = (x ^ (x >> 15)) * 2246822519u;
    x ^= x >> 13;
    vec3 base = mix(vec3(0.72), hue(float(x & 65535u) / 65536.0), 0.35 + 0.3 * float((x >> 16) & 255u) / 255.0);
    result = vec4(display(lit(base * base, 0.0, 0.7, n, 1.0)), 1);
  } else {
    vec3 width = fwidth(corner);
    vec3 near = smoothstep(width * 0.3, width * 1.3, corner);
    float line = 1.0 - min(near.x, min(near.y, near.z));
    // Lines are faded on triangles of a few pixels, which would be covered by lines.
    line *= clamp(1.6 - 2.2 * max(width.x, max(width.y, width.z)), 0.35, 1.0);
    vec3 surface = display(lit(vec3(0.5), 0.0, 0.8, n, 1.0));
    result = vec4(mix(surface, lineColor, 0.85 * line), 1);
  }
}
#else
in vec3 normal;
in vec4 uvs, color;
uniform vec4 baseColor;
uniform vec3 emissive;
uniform vec4 factors;
uniform float cutoff;
uniform bool unlit, hasNormalMap;
uniform int alphaMode;
uniform sampler2D baseTexture, metalTexture, normalTexture, occlusionTexture, emissiveTexture;
uniform mat3 uvMatrix[5];
uniform int uvSet[5];
vec2 uv(int i) { return (uvMatrix[i] * vec3(uvSet[i] == 0 ? uvs.xy : uvs.zw, 1)).xy; }

// Normal mapping without tangents, after Schüler, Normal mapping without precomputed tangents,
// 2006.
vec3 bumped(vec3 n) {
  vec2 at = uv(2);
  vec3 p = -cross(dFdy(place), n), q = cross(dFdx(place), n);
  vec2 s = dFdx(at), t = dFdy(at);
  vec3 tangent = p * s.x + q * t.x, bitangent = p * s.y + q * t.y;
  float size = max(dot(tangent, tangent), dot(bitangent, bitangent));
  if (size < 1e-30) return n;
  vec3 map = texture(normalTexture, at).xyz * 2.0 - 1.0;
  map.xy *= factors.z;
  return normalize(mat3(-tangent * inversesqrt(size), bitangent * inversesqrt(size), n) * vec3(map.x, -map.y, map.z));
}

void main() {
#ifdef NORMALS
  vec3 n = normalize(gl_FrontFacing ? normal : -normal);
  if (any(isnan(n))) n = normalize(cross(dFdx(place), dFdy(place)));
#else
  vec3 n = normalize(cross(dFdx(place), dFdy(place)));
#endif
  vec4 base = baseColor * color * texture(baseTexture, uv(0));
  if (alphaMode == 0) base.a = 1.0;
  if (alphaMode == 1) {
    if (base.a < cutoff) discard;
    base.a = 1.0;
  }
  if (mode == 1) {
    if (hasNormalMap) n = bumped(n);
    vec4 metal = texture(metalTexture, uv(1));
    float open = mix(1.0, texture(occlusionTexture, uv(3)).r, factors.w);
    vec3 shown = unlit ? base.rgb : lit(base.rgb, factors.x * metal.b, clamp(factors.y * metal.g, 0.05, 1.0), n, open);
    shown += emissive * texture(emissiveTexture, uv(4)).rgb;
    result = vec4(unlit ? pow(max(shown, 0.0), vec3(1.0 / 2.2)) : display(shown), base.a);
  } else if (mode == 4) result = vec4(n * 0.5 + 0.5, 1);
  else result = vec4(display(lit(vec3(0.5, 0.5, 0.52), 0.0, 0.55, n, 1.0)), 1);
  result.rgb *= result.a;
}
#endif`;

/**
 * Returns the source of a shader.
 * @param {string} source
 * @param {string[]} defines
 */
export const shaderSource = (source, defines) => HEAD + defines.map((name) => `#define ${name}\n`).join('') + source;
