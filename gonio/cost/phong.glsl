// Phong with normal mapping and environment reflection, as plainly as it is written by hand: what Elek
// (CESCG 2010, Table 1) compares layers with. `gonio cost --texts` compiles it; nothing else uses this file.

struct Plain {
    vec3 diffuse;
    vec3 specular;
    float shininess;
    vec3 mirror;
};

layout(binding = 0) uniform samplerCube environment_map;

vec3 plain_mapped_normal(vec3 normal, vec3 tangent, vec3 texel, float handedness) {
    vec3 n = normalize(normal);
    vec3 t = normalize(tangent - n * dot(n, tangent));
    vec3 b = handedness * cross(n, t);
    vec3 m = 2.0 * texel - 1.0;
    return normalize(m.x * t + m.y * b + m.z * n);
}

vec3 plain_shade(Plain params, vec3 normal, vec3 tangent, vec3 view, vec3 light, vec3 irradiance) {
    vec3 mirrored = reflect(-view, normal);
    float matte = max(dot(normal, light), 0.0);
    float glossy = pow(max(dot(mirrored, light), 0.0), params.shininess);
    vec3 around = textureLod(environment_map, mirrored, 0.0).rgb;
    return irradiance * (params.diffuse * matte + params.specular * glossy) + params.mirror * around;
}
