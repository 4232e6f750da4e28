// Values of the model at rows of directions: f and pdf, then a sample and its density.
//BEGIN
fn values_at(wi: vec3f, wo: vec3f) -> vec4f {
    let m: Model = model_load(P);
    return vec4f(model_eval(m, wi, wo), model_pdf(m, wi, wo));
}
fn drawn_at(wo: vec3f, u: vec2f) -> vec4f {
    let s: ModelSample = model_sample(model_load(P), wo, u);
    return vec4f(s.wi, s.pdf);
}
//END
