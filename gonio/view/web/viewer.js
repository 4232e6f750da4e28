/* gonio view, built from src/ by build.mjs; Apache-2.0. It contains these works of others:

lit-html
BSD 3-Clause License

Copyright (c) 2017 Google LLC. All rights reserved.

Redistribution and use in source and binary forms, with or without
modification, are permitted provided that the following conditions are met:

1. Redistributions of source code must retain the above copyright notice, this
   list of conditions and the following disclaimer.

2. Redistributions in binary form must reproduce the above copyright notice,
   this list of conditions and the following disclaimer in the documentation
   and/or other materials provided with the distribution.

3. Neither the name of the copyright holder nor the names of its
   contributors may be used to endorse or promote products derived from
   this software without specific prior written permission.

THIS SOFTWARE IS PROVIDED BY THE COPYRIGHT HOLDERS AND CONTRIBUTORS "AS IS"
AND ANY EXPRESS OR IMPLIED WARRANTIES, INCLUDING, BUT NOT LIMITED TO, THE
IMPLIED WARRANTIES OF MERCHANTABILITY AND FITNESS FOR A PARTICULAR PURPOSE ARE
DISCLAIMED. IN NO EVENT SHALL THE COPYRIGHT HOLDER OR CONTRIBUTORS BE LIABLE
FOR ANY DIRECT, INDIRECT, INCIDENTAL, SPECIAL, EXEMPLARY, OR CONSEQUENTIAL
DAMAGES (INCLUDING, BUT NOT LIMITED TO, PROCUREMENT OF SUBSTITUTE GOODS OR
SERVICES; LOSS OF USE, DATA, OR PROFITS; OR BUSINESS INTERRUPTION) HOWEVER
CAUSED AND ON ANY THEORY OF LIABILITY, WHETHER IN CONTRACT, STRICT LIABILITY,
OR TORT (INCLUDING NEGLIGENCE OR OTHERWISE) ARISING IN ANY WAY OUT OF THE USE
OF THIS SOFTWARE, EVEN IF ADVISED OF THE POSSIBILITY OF SUCH DAMAGE.
 */
var Xt=globalThis,pe=s=>s,xt=Xt.trustedTypes,ve=xt?xt.createPolicy("lit-html",{createHTML:s=>s}):void 0,xe="$lit$",F=`lit$${Math.random().toFixed(9).slice(2)}$`,ke="?"+F,_s=`<${ke}>`,V=document,at=()=>V.createComment(""),nt=s=>s===null||typeof s!="object"&&typeof s!="function",Jt=Array.isArray,As=s=>Jt(s)||typeof s?.[Symbol.iterator]=="function",Gt=`[ 	
\f\r]`,it=/<(?:(!--|\/[^a-zA-Z])|(\/?[a-zA-Z][^>\s]*)|(\/?$))/g,ge=/-->/g,we=/>/g,H=RegExp(`>|${Gt}(?:([^\\s"'>=/]+)(${Gt}*=${Gt}*(?:[^ 	
\f\r"'\`<>=]|("|')|))|$)`,"g"),$e=/'/g,be=/"/g,Me=/^(?:script|style|textarea|title)$/i,Kt=s=>(t,...e)=>({_$litType$:s,strings:t,values:e}),p=Kt(1),_=Kt(2),ji=Kt(3),ot=Symbol.for("lit-noChange"),U=Symbol.for("lit-nothing"),ye=new WeakMap,W=V.createTreeWalker(V,129);function _e(s,t){if(!Jt(s)||!s.hasOwnProperty("raw"))throw Error("invalid template strings array");return ve!==void 0?ve.createHTML(t):t}var Ss=(s,t)=>{let e=s.length-1,i=[],a,n=t===2?"<svg>":t===3?"<math>":"",o=it;for(let r=0;r<e;r++){let l=s[r],c,h,u=-1,d=0;for(;d<l.length&&(o.lastIndex=d,h=o.exec(l),h!==null);)d=o.lastIndex,o===it?h[1]==="!--"?o=ge:h[1]!==void 0?o=we:h[2]!==void 0?(Me.test(h[2])&&(a=RegExp("</"+h[2],"g")),o=H):h[3]!==void 0&&(o=H):o===H?h[0]===">"?(o=a??it,u=-1):h[1]===void 0?u=-2:(u=o.lastIndex-h[2].length,c=h[1],o=h[3]===void 0?H:h[3]==='"'?be:$e):o===be||o===$e?o=H:o===ge||o===we?o=it:(o=H,a=void 0);let g=o===H&&s[r+1].startsWith("/>")?" ":"";n+=o===it?l+_s:u>=0?(i.push(c),l.slice(0,u)+xe+l.slice(u)+F+g):l+F+(u===-2?r:g)}return[_e(s,n+(s[e]||"<?>")+(t===2?"</svg>":t===3?"</math>":"")),i]},rt=class s{constructor({strings:t,_$litType$:e},i){let a;this.parts=[];let n=0,o=0,r=t.length-1,l=this.parts,[c,h]=Ss(t,e);if(this.el=s.createElement(c,i),W.currentNode=this.el.content,e===2||e===3){let u=this.el.content.firstChild;u.replaceWith(...u.childNodes)}for(;(a=W.nextNode())!==null&&l.length<r;){if(a.nodeType===1){if(a.hasAttributes())for(let u of a.getAttributeNames())if(u.endsWith(xe)){let d=h[o++],g=a.getAttribute(u).split(F),m=/([.?@])?(.*)/.exec(d);l.push({type:1,index:n,name:m[2],strings:g,ctor:m[1]==="."?Ht:m[1]==="?"?Wt:m[1]==="@"?Vt:Z}),a.removeAttribute(u)}else u.startsWith(F)&&(l.push({type:6,index:n}),a.removeAttribute(u));if(Me.test(a.tagName)){let u=a.textContent.split(F),d=u.length-1;if(d>0){a.textContent=xt?xt.emptyScript:"";for(let g=0;g<d;g++)a.append(u[g],at()),W.nextNode(),l.push({type:2,index:++n});a.append(u[d],at())}}}else if(a.nodeType===8)if(a.data===ke)l.push({type:2,index:n});else{let u=-1;for(;(u=a.data.indexOf(F,u+1))!==-1;)l.push({type:7,index:n}),u+=F.length-1}n++}}static createElement(t,e){let i=V.createElement("template");return i.innerHTML=t,i}};function K(s,t,e=s,i){if(t===ot)return t;let a=i!==void 0?e._$Co?.[i]:e._$Cl,n=nt(t)?void 0:t._$litDirective$;return a?.constructor!==n&&(a?._$AO?.(!1),n===void 0?a=void 0:(a=new n(s),a._$AT(s,e,i)),i!==void 0?(e._$Co??=[])[i]=a:e._$Cl=a),a!==void 0&&(t=K(s,a._$AS(s,t.values),a,i)),t}var qt=class{constructor(t,e){this._$AV=[],this._$AN=void 0,this._$AD=t,this._$AM=e}get parentNode(){return this._$AM.parentNode}get _$AU(){return this._$AM._$AU}u(t){let{el:{content:e},parts:i}=this._$AD,a=(t?.creationScope??V).importNode(e,!0);W.currentNode=a;let n=W.nextNode(),o=0,r=0,l=i[0];for(;l!==void 0;){if(o===l.index){let c;l.type===2?c=new lt(n,n.nextSibling,this,t):l.type===1?c=new l.ctor(n,l.name,l.strings,this,t):l.type===6&&(c=new Yt(n,this,t)),this._$AV.push(c),l=i[++r]}o!==l?.index&&(n=W.nextNode(),o++)}return W.currentNode=V,a}p(t){let e=0;for(let i of this._$AV)i!==void 0&&(i.strings!==void 0?(i._$AI(t,i,e),e+=i.strings.length-2):i._$AI(t[e])),e++}},lt=class s{get _$AU(){return this._$AM?._$AU??this._$Cv}constructor(t,e,i,a){this.type=2,this._$AH=U,this._$AN=void 0,this._$AA=t,this._$AB=e,this._$AM=i,this.options=a,this._$Cv=a?.isConnected??!0}get parentNode(){let t=this._$AA.parentNode,e=this._$AM;return e!==void 0&&t?.nodeType===11&&(t=e.parentNode),t}get startNode(){return this._$AA}get endNode(){return this._$AB}_$AI(t,e=this){t=K(this,t,e),nt(t)?t===U||t==null||t===""?(this._$AH!==U&&this._$AR(),this._$AH=U):t!==this._$AH&&t!==ot&&this._(t):t._$litType$!==void 0?this.$(t):t.nodeType!==void 0?this.T(t):As(t)?this.k(t):this._(t)}O(t){return this._$AA.parentNode.insertBefore(t,this._$AB)}T(t){this._$AH!==t&&(this._$AR(),this._$AH=this.O(t))}_(t){this._$AH!==U&&nt(this._$AH)?this._$AA.nextSibling.data=t:this.T(V.createTextNode(t)),this._$AH=t}$(t){let{values:e,_$litType$:i}=t,a=typeof i=="number"?this._$AC(t):(i.el===void 0&&(i.el=rt.createElement(_e(i.h,i.h[0]),this.options)),i);if(this._$AH?._$AD===a)this._$AH.p(e);else{let n=new qt(a,this),o=n.u(this.options);n.p(e),this.T(o),this._$AH=n}}_$AC(t){let e=ye.get(t.strings);return e===void 0&&ye.set(t.strings,e=new rt(t)),e}k(t){Jt(this._$AH)||(this._$AH=[],this._$AR());let e=this._$AH,i,a=0;for(let n of t)a===e.length?e.push(i=new s(this.O(at()),this.O(at()),this,this.options)):i=e[a],i._$AI(n),a++;a<e.length&&(this._$AR(i&&i._$AB.nextSibling,a),e.length=a)}_$AR(t=this._$AA.nextSibling,e){for(this._$AP?.(!1,!0,e);t!==this._$AB;){let i=pe(t).nextSibling;pe(t).remove(),t=i}}setConnected(t){this._$AM===void 0&&(this._$Cv=t,this._$AP?.(t))}},Z=class{get tagName(){return this.element.tagName}get _$AU(){return this._$AM._$AU}constructor(t,e,i,a,n){this.type=1,this._$AH=U,this._$AN=void 0,this.element=t,this.name=e,this._$AM=a,this.options=n,i.length>2||i[0]!==""||i[1]!==""?(this._$AH=Array(i.length-1).fill(new String),this.strings=i):this._$AH=U}_$AI(t,e=this,i,a){let n=this.strings,o=!1;if(n===void 0)t=K(this,t,e,0),o=!nt(t)||t!==this._$AH&&t!==ot,o&&(this._$AH=t);else{let r=t,l,c;for(t=n[0],l=0;l<n.length-1;l++)c=K(this,r[i+l],e,l),c===ot&&(c=this._$AH[l]),o||=!nt(c)||c!==this._$AH[l],c===U?t=U:t!==U&&(t+=(c??"")+n[l+1]),this._$AH[l]=c}o&&!a&&this.j(t)}j(t){t===U?this.element.removeAttribute(this.name):this.element.setAttribute(this.name,t??"")}},Ht=class extends Z{constructor(){super(...arguments),this.type=3}j(t){this.element[this.name]=t===U?void 0:t}},Wt=class extends Z{constructor(){super(...arguments),this.type=4}j(t){this.element.toggleAttribute(this.name,!!t&&t!==U)}},Vt=class extends Z{constructor(t,e,i,a,n){super(t,e,i,a,n),this.type=5}_$AI(t,e=this){if((t=K(this,t,e,0)??U)===ot)return;let i=this._$AH,a=t===U&&i!==U||t.capture!==i.capture||t.once!==i.once||t.passive!==i.passive,n=t!==U&&(i===U||a);a&&this.element.removeEventListener(this.name,this,i),n&&this.element.addEventListener(this.name,this,t),this._$AH=t}handleEvent(t){typeof this._$AH=="function"?this._$AH.call(this.options?.host??this.element,t):this._$AH.handleEvent(t)}},Yt=class{constructor(t,e,i){this.element=t,this.type=6,this._$AN=void 0,this._$AM=e,this.options=i}get _$AU(){return this._$AM._$AU}_$AI(t){K(this,t)}};var Us=Xt.litHtmlPolyfillSupport;Us?.(rt,lt),(Xt.litHtmlVersions??=[]).push("3.3.3");var Ae=(s,t,e)=>{let i=e?.renderBefore??t,a=i._$litPart$;if(a===void 0){let n=e?.renderBefore??null;i._$litPart$=a=new lt(t.insertBefore(at(),n),n,void 0,e??{})}return a._$AI(s),a};var ct=Math.PI/180,Q=(s,t=0)=>[Math.sin(s)*Math.cos(t),Math.sin(s)*Math.sin(t),Math.cos(s)];function ht(s){let t=new Float32Array(12*s.length);return s.forEach(([e,i,a=[.5,.5]],n)=>{t.set(e,12*n),t.set(i,12*n+4),t.set(a,12*n+8)}),t}function Ps(s){let t=new Set;for(let e=-90;e<=90;e+=1.5)t.add(e);for(let e=0,i=.02;e<26;e++,i*=1.3)for(let a of[s-i,s+i])Math.abs(a)<90&&t.add(a);return t.add(s),[...t].sort((e,i)=>e-i)}var Zt=Array.from({length:61},(s,t)=>Math.min(1.5*t,89.9)),D=44;function zs(s,t){let e=Q(t,Math.PI/2),[i,a]=[Math.cos(s),Math.sin(s)],n=[i*e[0]+a*e[2],e[1],i*e[2]-a*e[0]],o=[a,0,i],r=2*(n[0]*o[0]+n[1]*o[1]+n[2]*o[2]),l=n.map((c,h)=>r*o[h]-c);return n[2]>0&&l[2]>0?[n,l]:null}async function Se(s,t,e){let{program:i}=t,a=t.packed(),n=Q(e*ct,Math.PI),o=Ps(e),r=[];for(let m=0;m<D;m++)for(let f=0;f<D;f++)r.push(zs((f+.5)/D*90*ct,(1-(m+.5)/D)*90*ct));let l=[...o.map(m=>[Q(m*ct),n]),...r.map(m=>m??[[0,0,-1],[0,0,1]])],c=await s.rows(i,a,ht(l)),h=o.map((m,f)=>({angle:m,f:[...c.subarray(8*f,8*f+3)],pdf:c[8*f+3]})),u=r.map((m,f)=>m?[...c.subarray(8*(o.length+f),8*(o.length+f)+3)]:null),d=new Float32Array(4*Zt.length);Zt.forEach((m,f)=>d.set(Q(m*ct),4*f));let g=await s.albedo(i,a,d);return{thetaO:e,slice:h,map:u,albedo:Zt.map((m,f)=>({angle:m,value:[...g.subarray(4*f,4*f+3)]}))}}var ut=`//BEGIN
fn texel_of(second: bool, x: i32, y: i32) -> vec3f {
let k: i32 = select(0, 1, second);
let w: i32 = i32(D[k].z);
let h: i32 = i32(D[k].w);
let cx: i32 = clamp(x, 0, w - 1);
let cy: i32 = clamp(y, 0, h - 1);
return film_at(second, cx, cy, w).rgb * select(D[2].x, D[2].y, second);
}
fn picture(second: bool, at: vec2f) -> vec3f {
let k: i32 = select(0, 1, second);
let q: vec2f = at * D[k].zw - 0.5;
let low: vec2f = floor(q);
let f: vec2f = q - low;
let x: i32 = i32(low.x);
let y: i32 = i32(low.y);
return mix(mix(texel_of(second, x, y), texel_of(second, x + 1, y), f.x),
mix(texel_of(second, x, y + 1), texel_of(second, x + 1, y + 1), f.x), f.y);
}
fn toned(x: vec3f) -> vec3f {
let tone: i32 = i32(D[1].y);
let y: f32 = dot(x, vec3f(0.2126, 0.7152, 0.0722));
if (tone == 1) { return x * ((1.0 + y / 16.0) / (1.0 + y)); }
if (tone == 2) {
let white: f32 = 1.379064;
let v: vec3f = 2.0 * x;
return white * ((v * (0.15 * v + 0.05) + 0.004) / (v * (0.15 * v + 0.5) + 0.06) - 0.0666667);
}
return x;
}
fn encoded(x: f32) -> f32 {
let y: f32 = clamp(x, 0.0, 1.0);
return select(1.055 * pow(max(y, 1e-9), 1.0 / 2.4) - 0.055, 12.92 * y, y < 0.0031308);
}
fn screen(at: vec2f) -> vec4f {
let mode: i32 = i32(D[0].x);
var place: vec2f = at;
var second: bool = mode == 1;
if (mode == 2) { second = at.x > D[0].y; }
if (mode == 3) { second = at.x > 0.5; place.x = fract(at.x * 2.0); }
var x: vec3f = picture(second, place);
if (mode == 4) { x = 10.0 * abs(picture(true, at) - picture(false, at)); }
else { x = toned(x * D[1].x); }
let noise: f32 = fract(52.9829189 * fract(dot(at * 4096.0, vec2f(0.06711056, 0.00583715)))) - 0.5;
return vec4f(vec3f(encoded(x.x), encoded(x.y), encoded(x.z)) + noise / 255.0, 1.0);
}
//END
`;var Qt=`//BEGIN
struct ModelSample { wi: vec3f, pdf: f32 }
fn model_whole(x: f32) -> f32 {
return select(x, 0.0, (bitcast<u32>(x) & 0x7f800000u) == 0x7f800000u);
}
fn model_eval(m: Model, wi: vec3f, wo: vec3f) -> vec3f {
if (min(wi.z, wo.z) <= 1e-18) { return vec3f(0.0); }
let f: vec3f = model_value(m, wi, wo);
return vec3f(model_whole(f.x), model_whole(f.y), model_whole(f.z));
}
fn model_pdf(m: Model, wi: vec3f, wo: vec3f) -> f32 {
if (min(wi.z, wo.z) <= 1e-18) { return 0.0; }
let both: vec3f = wi + wo;
let h: vec3f = both / max(length(both), 1e-20);
let theta: f32 = max(atan2(length(h.xy), h.z), 1e-5);
let t: f32 = sqrt(sqrt(theta / 1.57079633));
let crowded: f32 = 1.0 / (6.28318531 * sin(theta) * 6.28318531 * t * t * t);
return 0.5 * (wi.z / 3.14159265 + crowded / (4.0 * max(dot(h, wo), 1e-6)));
}
fn model_around(m: Model, wo: vec3f, u: vec2f, crowd: bool) -> vec3f {
let phi: f32 = 6.28318531 * u.y;
if (!crowd) {
let r: f32 = sqrt(u.x);
return vec3f(r * cos(phi), r * sin(phi), sqrt(max(1.0 - u.x, 1e-12)));
}
let theta: f32 = 1.57079633 * u.x * u.x * u.x * u.x;
let h: vec3f = vec3f(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta));
return 2.0 * dot(h, wo) * h - wo;
}
fn model_sample(m: Model, wo: vec3f, u: vec2f) -> ModelSample {
let crowd: bool = u.x >= 0.5;
let part: f32 = select(2.0 * u.x, 2.0 * u.x - 1.0, crowd);
let wi: vec3f = model_around(m, wo, vec2f(part, u.y), crowd);
return ModelSample(wi, model_pdf(m, wi, wo));
}
fn model_albedo(m: Model, wo: vec3f) -> vec3f {
var total: vec3f = vec3f(0.0);
for (var k: i32 = 0; k < 1600; k++) {
let u: vec2f = vec2f((f32(k % 40) + 0.5) / 40.0, (f32(k / 40) + 0.5) / 40.0);
for (var rule: i32 = 0; rule < 2; rule++) {
let wi: vec3f = model_around(m, wo, u, rule == 1);
let p: f32 = model_pdf(m, wi, wo);
if (p > 0.0) { total += model_eval(m, wi, wo) * (wi.z / (2.0 * p)); }
}
}
return total / 1600.0;
}
//END
`;var ft=`//BEGIN
fn values_at(wi: vec3f, wo: vec3f) -> vec4f {
let m: Model = model_load(P);
return vec4f(model_eval(m, wi, wo), model_pdf(m, wi, wo));
}
fn drawn_at(wo: vec3f, u: vec2f) -> vec4f {
let s: ModelSample = model_sample(model_load(P), wo, u);
return vec4f(s.wi, s.pdf);
}
//END
`;var dt=`@group(0) @binding(0) var<uniform> U: array<vec4f, 44>;
@group(0) @binding(1) var<uniform> P: array<vec4f, MEMBERS>;
@group(0) @binding(2) var<storage, read> nodes: array<vec4f>;
@group(0) @binding(3) var<storage, read> places: array<vec4f>;
@group(0) @binding(4) var<storage, read> looks: array<vec4f>;
@group(0) @binding(5) var<storage, read> alias_table: array<vec4f>;
@group(0) @binding(6) var sky: texture_2d<f32>;
@group(0) @binding(7) var maps: texture_2d_array<f32>;
@group(0) @binding(8) var<storage, read> before: array<vec4f>;
@group(0) @binding(9) var<storage, read_write> film: array<vec4f>;
//BEGIN
const TAU: f32 = 6.2831853;
const FAR: f32 = 1e30;
fn map_texel(at: vec2i, layer: i32) -> vec4f {
let size: vec2i = vec2i(textureDimensions(maps).xy);
return textureLoad(maps, ((at % size) + size) % size, layer, 0);
}
fn map_nearest(uv: vec2f, layer: i32) -> vec4f {
return map_texel(vec2i(floor(uv * vec2f(textureDimensions(maps).xy))), layer);
}
fn map_linear(uv: vec2f, layer: i32) -> vec4f {
let at: vec2f = uv * vec2f(textureDimensions(maps).xy) - 0.5;
let low: vec2f = floor(at);
let k: vec2i = vec2i(low);
let f: vec2f = at - low;
return mix(mix(map_texel(k, layer), map_texel(k + vec2i(1, 0), layer), f.x),
mix(map_texel(k + vec2i(0, 1), layer), map_texel(k + vec2i(1, 1), layer), f.x), f.y);
}
//MODEL
fn hash(x0: u32) -> u32 {
var x: u32 = x0;
x ^= x >> 16u; x *= 0x7feb352du; x ^= x >> 15u; x *= 0x846ca68bu; x ^= x >> 16u;
return x;
}
fn owen(x0: u32, seed: u32) -> u32 {
var x: u32 = reverseBits(x0);
x ^= x * 0x3d20adeau; x += seed; x *= (seed >> 16u) | 1u; x ^= x * 0x05526c56u; x ^= x * 0x53a22864u;
return reverseBits(x);
}
fn sobol2(index: u32) -> vec2u {
var second: u32 = 0u;
var column: u32 = 0x80000000u;
for (var i: u32 = index; i != 0u; i >>= 1u) {
if ((i & 1u) != 0u) { second ^= column; }
column ^= column >> 1u;
}
return vec2u(reverseBits(index), second);
}
var<private> pixel_seed: u32;
fn unit2(pair: u32) -> vec2f {
let seed: u32 = hash(pixel_seed ^ (pair * 0x9e3779b9u));
let point: vec2u = sobol2(owen(u32(U[0].z), seed));
let x: u32 = owen(point.x, hash(seed ^ 0x68bc21ebu));
let y: u32 = owen(point.y, hash(seed ^ 0x02e5be93u));
return vec2f(f32(x >> 8u), f32(y >> 8u)) * (1.0 / 16777216.0);
}
struct Hit { t: f32, what: i32, u: f32, v: f32 }
fn away_from_zero(x: f32) -> f32 { return select(x, 1e-12, abs(x) < 1e-12); }
fn box(o: vec3f, inv: vec3f, low: vec3f, high: vec3f, far: f32) -> f32 {
let a: vec3f = (low - o) * inv;
let b: vec3f = (high - o) * inv;
let near: vec3f = min(a, b);
let away: vec3f = max(a, b);
let t0: f32 = max(max(near.x, near.y), max(near.z, 0.0));
let t1: f32 = min(min(away.x, away.y), min(away.z, far));
return select(FAR, t0, t0 <= t1 * 1.0000004);
}
fn ball(o: vec3f, d: vec3f, far: f32) -> f32 {
let c: vec3f = U[8].xyz - o;
let b: f32 = dot(c, d);
let e: vec3f = c - b * d;
let q: f32 = U[8].w * U[8].w - dot(e, e);
if (q <= 0.0 || U[8].w <= 0.0) { return FAR; }
let s: f32 = sqrt(q);
let t: f32 = select(b - s, b + s, b - s < 1e-4);
return select(FAR, t, t > 1e-4 && t < far);
}
fn lamp_count() -> i32 { return i32(U[6].z); }
fn turned(v: vec3f, sense: f32) -> vec3f {
let s: f32 = U[6].y * sense;
return vec3f(U[6].x * v.x + s * v.z, v.y, U[6].x * v.z - s * v.x);
}
fn meet(o: vec3f, d: vec3f, far: f32, any: bool) -> Hit {
var hit: Hit = Hit(far, -1, 0.0, 0.0);
let t_ball: f32 = ball(o, d, hit.t);
if (t_ball < hit.t) { hit = Hit(t_ball, -2, 0.0, 0.0); if (any) { return hit; } }
for (var k: i32 = 0; k < lamp_count(); k++) {
let c: vec3f = turned(U[12 + 4 * k].xyz, 1.0);
let a: vec3f = turned(U[13 + 4 * k].xyz, 1.0);
let b: vec3f = turned(U[14 + 4 * k].xyz, 1.0);
let n: vec3f = cross(a, b);
let down: f32 = dot(n, d);
let t: f32 = dot(n, c - o) / select(down, 1e-20, down == 0.0);
if (t > 1e-3 && t < hit.t) {
let q: vec3f = o + t * d - c;
let x: f32 = dot(q, a) / dot(a, a);
let y: f32 = dot(q, b) / dot(b, b);
let inside: f32 = select(max(abs(x), abs(y)), sqrt(x * x + y * y), U[12 + 4 * k].w > 0.5);
if (inside <= 1.0) { hit = Hit(t, -3 - k, 0.0, 0.0); if (any) { return hit; } }
}
}
if (U[7].y < 1.0) { return hit; }
let inv: vec3f = 1.0 / vec3f(away_from_zero(d.x), away_from_zero(d.y), away_from_zero(d.z));
var stack: array<i32, 40>;
var top: i32 = 0;
var at: i32 = 0;
if (box(o, inv, nodes[0].xyz, nodes[1].xyz, hit.t) >= FAR) { return hit; }
loop {
let first: i32 = i32(nodes[2 * at].w);
let count: i32 = i32(nodes[2 * at + 1].w);
if (count > 0) {
for (var i: i32 = first; i < first + count; i++) {
let e1: vec3f = places[3 * i + 1].xyz;
let e2: vec3f = places[3 * i + 2].xyz;
let h: vec3f = cross(d, e2);
let a: f32 = dot(e1, h);
if (abs(a) > 1e-14) {
let f: f32 = 1.0 / a;
let s: vec3f = o - places[3 * i].xyz;
let u: f32 = f * dot(s, h);
let q: vec3f = cross(s, e1);
let v: f32 = f * dot(d, q);
let t: f32 = f * dot(e2, q);
if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-4 && t < hit.t) {
hit = Hit(t, i, u, v);
if (any) { return hit; }
}
}
}
if (top == 0) { break; }
top--; at = stack[top];
} else {
var one: i32 = first;
var two: i32 = first + 1;
var t1: f32 = box(o, inv, nodes[2 * one].xyz, nodes[2 * one + 1].xyz, hit.t);
var t2: f32 = box(o, inv, nodes[2 * two].xyz, nodes[2 * two + 1].xyz, hit.t);
if (t2 < t1) { let k: i32 = one; one = two; two = k; let t: f32 = t1; t1 = t2; t2 = t; }
if (t1 >= FAR) { if (top == 0) { break; } top--; at = stack[top]; }
else { at = one; if (t2 < FAR) { stack[top] = two; top++; } }
}
}
return hit;
}
fn ground_at(o: vec3f, d: vec3f) -> f32 {
let t: f32 = -o.y / select(d.y, 1e-20, d.y == 0.0);
return select(FAR, t, U[7].w > 0.0 && t > 1e-4);
}
fn ground_share(p: vec3f) -> f32 {
let t: f32 = clamp((length(p.xz) - U[7].z) / max(U[7].w - U[7].z, 1e-6), 0.0, 1.0);
let x: f32 = 1.0 - t * t * (3.0 - 2.0 * t);
return x * x;
}
fn sky_texel(x: i32, y: i32) -> vec3f {
let w: i32 = i32(U[10].x);
return textureLoad(sky, vec2i(((x % w) + w) % w, clamp(y, 0, i32(U[10].y) - 1)), 0).rgb;
}
fn sky_place(d: vec3f) -> vec2f {
let w: vec3f = turned(d, -1.0);
return vec2f(fract(atan2(-w.x, w.z) / TAU), acos(clamp(w.y, -1.0, 1.0)) / (0.5 * TAU)) * U[10].xy;
}
fn surround(d: vec3f) -> vec3f {
if (U[5].w < 0.5) { return U[5].xyz; }
let at: vec2f = sky_place(d) - 0.5;
let low: vec2f = floor(at);
let f: vec2f = at - low;
let k: vec2i = vec2i(low);
let value: vec3f = mix(mix(sky_texel(k.x, k.y), sky_texel(k.x + 1, k.y), f.x),
mix(sky_texel(k.x, k.y + 1), sky_texel(k.x + 1, k.y + 1), f.x), f.y);
return value * U[5].xyz;
}
fn sky_pdf(d: vec3f) -> f32 {
let at: vec2u = min(vec2u(sky_place(d)), vec2u(U[10].xy) - 1u);
return U[6].w * alias_table[at.y * u32(U[10].x) + at.x].z;
}
fn lamp_weight(k: i32, o: vec3f, n: vec3f) -> f32 {
let way: vec3f = turned(U[12 + 4 * k].xyz, 1.0) - o;
let square: f32 = max(dot(way, way), 1e-6);
let d: vec3f = way / sqrt(square);
let m: vec3f = turned(normalize(cross(U[13 + 4 * k].xyz, U[14 + 4 * k].xyz)), 1.0);
let above: f32 = clamp(dot(n, d) + sqrt(U[13 + 4 * k].w / square), 0.05, 1.0);
return U[15 + 4 * k].w * (0.1 + max(-dot(m, d), 0.0)) * above / square;
}
fn lamp_total(o: vec3f, n: vec3f) -> f32 {
var total: f32 = 0.0;
for (var k: i32 = 0; k < lamp_count(); k++) { total += lamp_weight(k, o, n); }
return total;
}
fn lamp_pdf(k: i32, o: vec3f, n: vec3f, t: f32, d: vec3f) -> f32 {
let m: vec3f = turned(normalize(cross(U[13 + 4 * k].xyz, U[14 + 4 * k].xyz)), 1.0);
let chosen: f32 = (1.0 - U[6].w) * lamp_weight(k, o, n) / max(lamp_total(o, n), 1e-20);
return chosen * t * t / (max(-dot(m, d), 1e-6) * U[13 + 4 * k].w);
}
struct Light { d: vec3f, far: f32, radiance: vec3f, pdf: f32 }
fn sample_light(o: vec3f, normal: vec3f, u: vec2f, choice: vec2f) -> Light {
if (choice.x < U[6].w) {
let size: vec2u = vec2u(U[10].xy);
let x: f32 = choice.x / U[6].w * f32(size.x * size.y);
let cell: u32 = min(u32(x), size.x * size.y - 1u);
let entry: vec4f = alias_table[cell];
let k: u32 = select(u32(entry.y), cell, choice.y < entry.x);
let place: vec2f = vec2f(f32(k % size.x) + u.x, f32(k / size.x) + u.y) / U[10].xy;
let th: f32 = place.y * 0.5 * TAU;
let ph: f32 = place.x * TAU;
let d: vec3f = turned(vec3f(-sin(th) * sin(ph), cos(th), sin(th) * cos(ph)), 1.0);
return Light(d, FAR, surround(d), U[6].w * alias_table[k].z);
}
var k: i32 = 0;
var rest: f32 = (choice.x - U[6].w) / (1.0 - U[6].w) * lamp_total(o, normal);
for (; k < lamp_count() - 1; k++) {
let weight: f32 = lamp_weight(k, o, normal);
if (rest < weight) { break; }
rest -= weight;
}
var s: vec2f = 2.0 * u - 1.0;
if (U[12 + 4 * k].w > 0.5) { s = sqrt(u.x) * vec2f(cos(TAU * u.y), sin(TAU * u.y)); }
let at: vec3f = turned(U[12 + 4 * k].xyz + s.x * U[13 + 4 * k].xyz + s.y * U[14 + 4 * k].xyz, 1.0);
let way: vec3f = at - o;
let t: f32 = length(way);
let d: vec3f = way / t;
let n: vec3f = turned(normalize(cross(U[13 + 4 * k].xyz, U[14 + 4 * k].xyz)), 1.0);
if (dot(n, d) >= 0.0 || lamp_count() < 1) { return Light(d, 0.0, vec3f(0.0), 0.0); }
return Light(d, t * 0.9999, U[15 + 4 * k].xyz, lamp_pdf(k, o, normal, t, d));
}
fn any_frame(n: vec3f) -> vec3f {
return normalize(cross(select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(n.y) > 0.99), n));
}
fn path(origin: vec3f, direction: vec3f) -> vec3f {
var o: vec3f = origin;
var d: vec3f = direction;
var L: vec3f = vec3f(0.0);
var T: vec3f = vec3f(1.0);
var pdf: f32 = -1.0;
var facing: vec3f = vec3f(0.0);
let furnace: bool = U[3].w > 0.5;
let way: i32 = i32(U[9].z);
let depth: i32 = i32(U[4].w);
for (var b: i32 = 0; b < depth; b++) {
var hit: Hit = meet(o, d, FAR, false);
let t_ground: f32 = ground_at(o, d);
if (t_ground < hit.t && unit2(u32(4 * b + 4)).y < ground_share(o + t_ground * d)) {
hit = Hit(t_ground, 1 << 30, 0.0, 0.0);
}
if (hit.what == -1) {
var w: f32 = 1.0;
if (U[6].w > 0.0 && pdf >= 0.0) { w = pdf / (pdf + sky_pdf(d)); if (way == 1) { w = 1.0; } if (way == 2) { w = 0.0; } }
L += T * surround(d) * w;
break;
}
if (hit.what < -2) {
let k: i32 = -3 - hit.what;
let n: vec3f = turned(cross(U[13 + 4 * k].xyz, U[14 + 4 * k].xyz), 1.0);
if (dot(n, d) < 0.0) {
var w: f32 = 1.0;
if (pdf >= 0.0) { w = pdf / (pdf + lamp_pdf(k, o, facing, hit.t, d)); if (way == 1) { w = 1.0; } if (way == 2) { w = 0.0; } }
L += T * U[15 + 4 * k].xyz * w;
}
break;
}
if (b == depth - 1) { break; }
let x: vec3f = o + hit.t * d;
var p: vec3f = x;
var ng: vec3f;
var n: vec3f;
var du: vec3f;
var uv: vec2f = vec2f(0.0);
var growth: f32 = 0.5;
var kind: i32 = 0;
if (hit.what == 1 << 30) {
ng = vec3f(0.0, 1.0, 0.0);
n = ng;
du = vec3f(1.0, 0.0, 0.0);
kind = 3;
} else if (hit.what == -2) {
n = normalize(x - U[8].xyz);
ng = n;
du = vec3f(-n.z, 0.0, n.x);
uv = vec2f(fract(atan2(-n.x, -n.z) / TAU + 1.0), acos(clamp(n.y, -1.0, 1.0)) / (0.5 * TAU));
p = U[8].xyz + U[8].w * n;
} else {
let i: i32 = hit.what;
let p0: vec3f = places[3 * i].xyz;
let e1: vec3f = places[3 * i + 1].xyz;
let e2: vec3f = places[3 * i + 2].xyz;
let n0: vec3f = looks[5 * i].xyz;
let n1: vec3f = looks[5 * i + 1].xyz;
let n2: vec3f = looks[5 * i + 2].xyz;
let a: f32 = 1.0 - hit.u - hit.v;
kind = i32(places[3 * i].w);
ng = normalize(cross(e1, e2));
n = normalize(a * n0 + hit.u * n1 + hit.v * n2);
growth = a * looks[5 * i].w + hit.u * looks[5 * i + 1].w + hit.v * looks[5 * i + 2].w;
let t01: vec4f = looks[5 * i + 3];
let t2: vec2f = looks[5 * i + 4].xy;
uv = a * t01.xy + hit.u * t01.zw + hit.v * t2;
let s1: vec2f = t01.zw - t01.xy;
let s2: vec2f = t2 - t01.xy;
du = (e1 * s2.y - e2 * s1.y) * sign(s1.x * s2.y - s1.y * s2.x);
p = p0 + hit.u * e1 + hit.v * e2;
let side: f32 = select(-1.0, 1.0, dot(ng, d) < 0.0);
let q0: vec3f = p - p0;
let q1: vec3f = q0 - e1;
let q2: vec3f = q0 - e2;
let l0: f32 = min(0.0, side * dot(q0, n0));
let l1: f32 = min(0.0, side * dot(q1, n1));
let l2: f32 = min(0.0, side * dot(q2, n2));
if (kind == 0) { p -= side * (a * l0 * n0 + hit.u * l1 * n1 + hit.v * l2 * n2); }
}
if (kind == 0) {
let bump: vec3f = normal_at(uv);
if (abs(bump.x) + abs(bump.y) > 1e-4) {
let across: vec3f = du - dot(du, n) * n;
let u_axis: vec3f = select(any_frame(n), across / max(length(across), 1e-20), dot(across, across) > 1e-16);
n = normalize(bump.x * u_axis + bump.y * cross(n, u_axis) + bump.z * n);
}
}
if (dot(ng, d) > 0.0) { ng = -ng; n = -n; }
let below: f32 = dot(n, d);
if (below > -1e-3) { n = normalize(n - (below + 1e-3) * d); }
du = du - dot(du, n) * n;
let tx: vec3f = select(any_frame(n), du / max(length(du), 1e-20), dot(du, du) > 1e-16);
let ty: vec3f = cross(n, tx);
let wo: vec3f = vec3f(-dot(d, tx), -dot(d, ty), -dot(d, n));
p += 1e-4 * ng;
let u_light: vec2f = unit2(u32(4 * b + 1));
let u_choice: vec2f = unit2(u32(4 * b + 2));
let u_model: vec2f = unit2(u32(4 * b + 3));
let test: bool = kind == 0;
let grey: vec3f = select(vec3f(select(0.12, 0.32, kind == 1)), U[11].xyz, kind == 3) / (0.5 * TAU);
var m: Model = model_at(uv, growth, hit.t);
let lit: bool = !furnace && way != 1 && (U[6].w > 0.0 || lamp_count() > 0);
if (lit) {
let light: Light = sample_light(p, n, u_light, u_choice);
let wi: vec3f = vec3f(dot(light.d, tx), dot(light.d, ty), dot(light.d, n));
if (light.pdf > 0.0 && wi.z > 0.0) {
var f: vec3f = grey;
var q: f32 = wi.z / (0.5 * TAU);
if (test) { f = model_eval(m, wi, wo); q = model_pdf(m, wi, wo); }
if (way == 2) { q = 0.0; }
let e: vec3f = f * light.radiance * (wi.z / (light.pdf + q));
if (max(e.x, max(e.y, e.z)) > 0.0 && meet(p, light.d, light.far, true).what == -1) {
let t_below: f32 = ground_at(p, light.d);
let through: f32 = select(1.0, 1.0 - ground_share(p + t_below * light.d), t_below < light.far);
L += T * e * through;
}
}
}
var wi: vec3f;
if (test) {
let s: ModelSample = model_sample(m, wo, u_model);
if (s.pdf <= 0.0) { break; }
wi = s.wi;
pdf = s.pdf;
T *= model_eval(m, wi, wo) * (wi.z / pdf);
} else {
let r: f32 = sqrt(u_model.x);
wi = vec3f(r * cos(TAU * u_model.y), r * sin(TAU * u_model.y), sqrt(max(1.0 - u_model.x, 1e-12)));
pdf = wi.z / (0.5 * TAU);
T *= grey * 0.5 * TAU;
}
d = normalize(tx * wi.x + ty * wi.y + n * wi.z);
o = p;
facing = n;
let left: f32 = max(T.x, max(T.y, T.z));
if (left <= 0.0) { break; }
if (!furnace && b >= 2 && left < 1.0) {
let keep: f32 = max(left, 0.05);
if (unit2(u32(4 * b + 4)).x >= keep) { break; }
T /= keep;
}
}
return L;
}
fn pixel(at: vec2u) -> vec4f {
pixel_seed = hash(at.x + hash(at.y + hash(u32(U[0].w))));
let q: vec2f = ((vec2f(at) + unit2(0u)) / U[0].xy * 2.0 - 1.0) * vec2f(U[2].w, -1.0) * U[1].w;
let L: vec3f = path(U[1].xyz, normalize(U[4].xyz + q.x * U[2].xyz + q.y * U[3].xyz));
let lum: f32 = dot(L, vec3f(0.2126, 0.7152, 0.0722));
return vec4f(L, lum * lum);
}
//END
@compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
let size = vec2u(U[0].xy);
let at = vec2u(id.x, id.y + u32(U[9].x));
if (at.x >= size.x || at.y >= min(size.y, u32(U[9].y))) { return; }
let i = at.y * size.x + at.x;
film[i] = select(before[i], vec4f(0.0), U[0].z < 0.5) + pixel(at);
}
`;var Cs={wgsl:`fn model_at(uv: vec2f, growth: f32, t: f32) -> Model {
    var m: Model = model_load(P);
`,essl:`Model model_at(vec2 uv, float growth, float t) {
    Model m = model_load(P);
`};function ee(s,t){let e=r=>`uv * ${t==="wgsl"?"vec2f":"vec2"}(${r.scale.map(te).join(", ")})`,i=s.hooks.find(r=>r.source==="normal_map"),a=i?`2.0 * map_linear(${e(i)}, ${i.layer}).xyz - 1.0`:t==="wgsl"?"vec3f(0.0, 0.0, 1.0)":"vec3(0.0, 0.0, 1.0)",n=t==="wgsl"?`fn normal_at(uv: vec2f) -> vec3f { return ${a}; }
`:`vec3 normal_at(vec2 uv) { return ${a}; }
`,o=s.hooks.filter(r=>r!==i).map(r=>{let l=`m.${r.members[t]}`;if(r.source==="mesh")return`    ${l} = growth;`;if(r.source==="viewer")return`    ${l} = t / ${te(r.unit)};`;let c=r.source==="flakes"?`map_nearest(uv * ${te(r.tiles)}, ${r.layer})`:`map_linear(${e(r)}, ${r.layer})`;return`    ${l} = ${c}.${r.width===3?"rgb":"xy"[r.channel]};`});return`${n}${Cs[t]}${o.join(`
`)}
    return m;
}
`}var te=s=>Number.isInteger(s)?`${s}.0`:String(s),Is=[dt,ft,ut,Qt].join(`
`),Ns=new Set([...Is.matchAll(/(?:\bfn|\bconst|\bstruct|\bvar<[^>]*>|\) var) (\w+)/g)].map(s=>s[1]).concat("P","given","made","drawn","D","film_a","film_b","shown","row_of","reverse_bits","main").filter(s=>!/^Model|^model_/.test(s)));function mt(s,t,e=i=>i){let i=s.code[t];return s.foreign&&(i=i.replace(/\b[A-Za-z_]\w*/g,a=>Ns.has(a)?`${a}_user`:a)+e(Qt).replace(/^.*\/\/BEGIN|\/\/END.*$/gs,"")),`${i}
${s.load[t]}
`}var Y=s=>Math.max(1,s.members.length);function Ue(s){return dt.replace("MEMBERS",Y(s)).replace("//MODEL",()=>mt(s,"wgsl")+ee(s,"wgsl"))}var Pe=s=>`@group(0) @binding(0) var<uniform> P: array<vec4f, ${s}>;
@group(0) @binding(1) var<storage, read> given: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> made: array<vec4f>;
`;function ze(s){return`${Pe(Y(s))}${mt(s,"wgsl")}${ft}
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if (3u * i + 2u >= arrayLength(&given)) { return; }
    made[2u * i] = values_at(given[3u * i].xyz, given[3u * i + 1u].xyz);
    made[2u * i + 1u] = drawn_at(given[3u * i + 1u].xyz, given[3u * i + 2u].xy);
}`}function Te(s){return`${Pe(Y(s))}${mt(s,"wgsl")}
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&given)) { return; }
    made[id.x] = vec4f(model_albedo(model_load(P), given[id.x].xyz), 0.0);
}`}var Ee=`@group(0) @binding(0) var<uniform> D: array<vec4f, 4>;
@group(0) @binding(1) var<storage, read> film_a: array<vec4f>;
@group(0) @binding(2) var<storage, read> film_b: array<vec4f>;
fn film_at(second: bool, x: i32, y: i32, w: i32) -> vec4f {
    if (second) { return film_b[y * w + x]; }
    return film_a[y * w + x];
}
${ut}
@vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(select(-1.0, 3.0, i == 1u), select(-1.0, 3.0, i == 2u), 0.0, 1.0);
}
@fragment fn pixel(@builtin(position) at: vec4f) -> @location(0) vec4f { return screen(at.xy / D[3].xy); }`;function I(s,t){let e=Uint8Array.fromBase64?.(s)??Uint8Array.from(atob(s),i=>i.charCodeAt(0));return new t(e.buffer)}function At({rows:s,entries:t}){let e=I(s,Float32Array),i=new Float32Array(4*t);for(let a=0;a<3*t;a++)i[a+Math.floor(a/3)]=e[a];return i}function St(s){return Float32Array.from(s,t=>{let e=t&32768?-1:1,i=t>>10&31,a=t&1023;return i===0?e*a*2**-24:i===31?a?NaN:e*(1/0):e*(1+a/1024)*2**(i-15)})}var Oe=s=>import(`data:text/javascript;charset=utf-8,${encodeURIComponent(s)}`),kt=class{live=!0;constructor(t){this.token=t}async#t(t,e){let i;try{i=await fetch(t,{method:"POST",body:JSON.stringify(e),headers:{"Content-Type":"application/json","X-Gonio-Token":this.token}})}catch{throw new Error("gonio view is not running any more; start it again and reload this page.")}let a=await i.json().catch(()=>({error:`The server answered ${i.status}.`}));if(!i.ok)throw Object.assign(new Error(a.error),a);return a}part(t){return import(`/${t}.js`)}async file(t){return(await fetch(`/${t}`)).text()}start(){return this.#t("/api/start",{})}model(t){return this.#t("/api/model",{text:t})}options(t){return this.#t("/api/options",{text:t})}albedo(t,e){return this.#t("/api/albedo",{text:t,wo:e}).then(i=>i.albedo)}code(t,e){return this.#t("/api/code",{text:t,language:e}).then(i=>i.text)}watch(t){let e=new BroadcastChannel("gonio changes");e.onmessage=({data:a})=>t(a);let i=()=>this.#s(a=>{e.postMessage(a),t(a)});navigator.locks?navigator.locks.request("gonio changes",i):i()}async#s(t){for(let e=!1;;){let i=await fetch("/api/changes",{method:"POST",body:"{}",headers:{"Content-Type":"application/json","X-Gonio-Token":this.token}}).catch(()=>null);if(i&&!i.ok)return;!i!==e&&(e=!i,t({ended:e}));try{let a=i.body.pipeThrough(new TextDecoderStream).getReader();for(let n="";;){let{value:o,done:r}=await a.read();if(r)break;let l=(n+o).split(`

`);n=l.pop();for(let c of l)c.startsWith("data: ")&&t(JSON.parse(c.slice(6)))}}catch{}await new Promise(a=>setTimeout(a,1500))}}},Mt=class{live=!1;constructor(t){this.data=t}async part(t){return Oe(await this.file(`${t}.js`))}async file(t){return this.data.files[t]}async start(){return this.data}async model(t){let[e,i=""]=[t.split(":")[0],t.slice(t.indexOf(":")+1)],a=this.data.models[t]??Object.values(this.data.models).find(c=>c.name===e);if(!a){let c=Object.keys(this.data.models);throw new Error(c.length>4?`This saved page holds ${c.length} models and materials, but not this one.`:`This saved page holds ${c.join(" and ")} alone; 'gonio view' has all models.`)}let n=new Map(t.includes(":")?i.split(",").map(c=>[c.slice(0,c.indexOf("=")),c.slice(c.indexOf("=")+1)]):[]);for(let{path:c,value:h,default:u}of a.models)if((n.get(c)??a.start[c]??u)!==h)throw new Error("This saved page has its layers as they are; 'gonio view' changes them.");let o=a.options.map(c=>[c.path,n.get(c.path)??a.start[c.path]??c.default]),r=o.every(([,c],h)=>a.options[h].value===c)?a:this.#t(a,`${e}|${o.map(([c,h])=>`${c}=${h}`).join()}`),l=r.parameters.map(c=>{let h=n.has(c.path)?n.get(c.path).split("/").map(Number):[a.start[c.path]??c.default].flat();return{...c,value:Array.from({length:c.width},(u,d)=>h[d]??h[0])}});return{...r,parameters:l}}#t(t,e){let i=this.data.variants?.[e];if(!i)throw new Error("This saved page has no shader for that choice; 'gonio view' has them all.");let a=n=>i[n].map(o=>this.data.pool[n][o]).join(`

`);return{...t,...i.about,code:{wgsl:a("wgsl"),essl:a("essl")}}}async code(t,e){let i=(await this.model(t)).code[e];if(i===void 0)throw new Error("This saved page holds WGSL and GLSL ES only; 'gonio view' has every language.");return i}watch(){}},_t=class{live=!0;#t=new Map;#s=0;constructor(t){this.widget=t,t.on("msg:custom",e=>{let i=this.#t.get(e.id);i&&(this.#t.delete(e.id),e.error?i.reject(new Error(e.error)):i.resolve(e.answer))})}#e(t,e){let i=++this.#s;return this.widget.send({id:i,question:t,body:e}),new Promise((a,n)=>{this.#t.set(i,{resolve:a,reject:n}),setTimeout(()=>{this.#t.delete(i)&&n(new Error("The notebook's kernel does not answer; is it busy?"))},3e4)})}async part(t){return Oe(await this.file(`${t}.js`))}async file(t){return(await this.#e("file",{text:t})).text}start(){return this.#e("start",{})}model(t){return this.#e("model",{text:t})}options(t){return this.#e("options",{text:t})}albedo(t,e){return this.#e("albedo",{text:t,wo:e}).then(i=>i.albedo)}code(t,e){return this.#e("code",{text:t,language:e}).then(i=>i.text)}watch(){}};var Ls=44,Rs=s=>s.filter(t=>t.type==="error").map(t=>`${t.message} (line ${t.lineNum})`)[0],pt=null;async function Fs(){pt??={users:0,coming:Ds()};let s=pt;s.users++;try{return{...await s.coming,taken:s}}catch(t){throw pt=null,t}}async function Ds(){let s=await navigator.gpu.requestAdapter({powerPreference:"high-performance"});if(!s)throw new Error("The browser has WebGPU but no adapter: the driver is blocked or there is no GPU.");let t=Math.min(s.limits.maxStorageBufferBindingSize,1<<30),e=await s.requestDevice({requiredLimits:{maxStorageBufferBindingSize:t,maxBufferSize:Math.min(s.limits.maxBufferSize,1<<30)}});return e.lost.then(()=>{pt=null}),{device:e,adapter:s}}var Ut=class s{name="WebGPU";language="wgsl";static async create(){if(!globalThis.isSecureContext)throw new Error("This page came over http:// from another machine, and browsers give WebGPU to secure contexts only.");if(!navigator.gpu)throw new Error("This browser has no WebGPU.");let{device:t,adapter:e,taken:i}=await Fs();return Object.assign(new s(t,e),{taken:i})}constructor(t,e){this.device=t,this.adapter=e.info?.description||e.info?.vendor||"",this.canvas=document.createElement("canvas"),this.context=this.canvas.getContext("webgpu"),this.format=navigator.gpu.getPreferredCanvasFormat(),this.context.configure({device:t,format:this.format,alphaMode:"opaque"}),this.errors=[],t.addEventListener("uncapturederror",c=>this.errors.push(c.error.message)),this.lost=t.lost;let i=c=>({buffer:{type:c}}),a=i("read-only-storage"),n=[i("uniform"),i("uniform"),a,a,a,a,{texture:{sampleType:"unfilterable-float"}},{texture:{sampleType:"unfilterable-float",viewDimension:"2d-array"}},a,i("storage")];this.traceGroup=t.createBindGroupLayout({entries:n.map((c,h)=>({binding:h,visibility:GPUShaderStage.COMPUTE,...c}))});let o=[i("uniform"),a,i("storage")];this.numberGroup=t.createBindGroupLayout({entries:o.map((c,h)=>({binding:h,visibility:GPUShaderStage.COMPUTE,...c}))}),this.tableGroup=t.createBindGroupLayout({entries:[{binding:8,visibility:GPUShaderStage.COMPUTE,...a}]}),this.settings=t.createBuffer({size:16*Ls,usage:GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST}),this.screen=t.createBuffer({size:64,usage:GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST});let r=new Float32Array(8);this.scene={nodes:this.#t(r),places:this.#t(r),looks:this.#t(r)},this.setSky({width:1,height:1,pixels:new Float32Array(4),alias:new Float32Array(4)});let l=t.createShaderModule({code:Ee});this.display=t.createRenderPipeline({layout:"auto",vertex:{module:l,entryPoint:"corner"},fragment:{module:l,entryPoint:"pixel",targets:[{format:this.format}]}})}close(){--this.taken.users===0&&(pt=null,this.device.destroy())}#t(t,e=GPUBufferUsage.STORAGE){let i=this.device.createBuffer({size:Math.max(t.byteLength,16),usage:e|GPUBufferUsage.COPY_DST});return this.device.queue.writeBuffer(i,0,t),i}setScene({nodes:t,places:e,looks:i}){for(let a of Object.values(this.scene))a.destroy();this.scene={nodes:this.#t(t),places:this.#t(e),looks:this.#t(i)}}setSky({width:t,height:e,pixels:i,alias:a}){this.sky?.destroy(),this.alias?.destroy(),this.sky=this.device.createTexture({size:[t,e],format:"rgba32float",usage:GPUTextureUsage.TEXTURE_BINDING|GPUTextureUsage.COPY_DST}),this.device.queue.writeTexture({texture:this.sky},i,{bytesPerRow:16*t},[t,e]),this.alias=this.#t(a)}makeSide(){return{films:[],front:0,width:0,height:0,maps:this.#s({size:1,layers:1,pixels:new Float32Array(4)})}}#s({size:t,layers:e,pixels:i}){let a=this.device.createTexture({size:[t,t,e],format:"rgba32float",usage:GPUTextureUsage.TEXTURE_BINDING|GPUTextureUsage.COPY_DST});return this.device.queue.writeTexture({texture:a},i,{bytesPerRow:16*t,rowsPerImage:t},[t,t,e]),a}setMaps(t,e){t.maps.destroy(),t.maps=this.#s(e)}async compile(t,{trace:e=!0}={}){let i=e?await this.#i(Ue(t),this.traceGroup,t):null,a=this.device.createBuffer({size:16*Y(t),usage:GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST}),n={model:t,trace:i,params:a};return t.tables&&(n.tables=this.#t(At(t.tables)),n.tableGroup=this.device.createBindGroup({layout:this.tableGroup,entries:[{binding:8,resource:{buffer:n.tables}}]})),e||await this.#e(n),n}async#e(t){t.rows??=await(t.rowsComing??=this.#a(t,ze))}#a({model:t},e){return this.#i(e(t),this.numberGroup,t)}async#i(t,e,i){let a=this.device.createShaderModule({code:t}),n=this.device.createPipelineLayout({bindGroupLayouts:i.tables?[e,this.tableGroup]:[e]});try{return await this.device.createComputePipelineAsync({layout:n,compute:{module:a,entryPoint:"main"}})}catch(o){throw new Error(Rs((await a.getCompilationInfo()).messages)??o.message)}}forget(t){t.params.destroy(),t.tables?.destroy()}#n(t,e){let i=e.map((a,n)=>({binding:n,resource:a instanceof GPUBuffer?{buffer:a}:a}));return this.device.createBindGroup({layout:t,entries:i})}resize(t,e,i){t.wanted=[e,i]}trace(t,e,i,a,n,o){let[r,l]=t.wanted,c=1-t.front;(t.films[c]?.width!==r||t.films[c]?.height!==l)&&(t.films[c]?.buffer.destroy(),t.films[c]={width:r,height:l,buffer:this.device.createBuffer({size:16*r*l,usage:GPUBufferUsage.STORAGE|GPUBufferUsage.COPY_SRC})});let h=a[2]>0?t.films[t.front].buffer:this.#f();a[36]=n,a[37]=o,this.device.queue.writeBuffer(this.settings,0,a),this.device.queue.writeBuffer(e.params,0,i);let{nodes:u,places:d,looks:g}=this.scene,m=t.maps.createView({dimension:"2d-array"}),f=this.#n(this.traceGroup,[this.settings,e.params,u,d,g,this.alias,this.sky.createView(),m,h,t.films[c].buffer]),v=this.device.createCommandEncoder(),w=v.beginComputePass();return w.setPipeline(e.trace),w.setBindGroup(0,f),e.tableGroup&&w.setBindGroup(1,e.tableGroup),w.dispatchWorkgroups(Math.ceil(r/8),Math.ceil((o-n)/8)),w.end(),this.device.queue.submit([v.finish()]),this.device.queue.onSubmittedWorkDone()}#f(){return this.empty??=this.#t(new Float32Array(4))}swap(t){t.front=1-t.front,Object.assign(t,{width:t.films[t.front].width,height:t.films[t.front].height})}show(t,e,i){let a=r=>r?.films[r.front]?.buffer;if(!a(t))return;this.device.queue.writeBuffer(this.screen,0,i);let n=this.device.createCommandEncoder(),o=n.beginRenderPass({colorAttachments:[{view:this.context.getCurrentTexture().createView(),loadOp:"clear",storeOp:"store"}]});o.setPipeline(this.display),o.setBindGroup(0,this.#n(this.display.getBindGroupLayout(0),[this.screen,a(t),a(e)??a(t)])),o.draw(3),o.end(),this.device.queue.submit([n.finish()])}async#o(t,e){let i=this.device.createBuffer({size:e,usage:GPUBufferUsage.COPY_DST|GPUBufferUsage.MAP_READ}),a=this.device.createCommandEncoder();a.copyBufferToBuffer(t,0,i,0,e),this.device.queue.submit([a.finish()]),await i.mapAsync(GPUMapMode.READ);let n=new Float32Array(i.getMappedRange().slice(0));return i.destroy(),n}readFilm(t){let e=t.films[t.front];return this.#o(e.buffer,16*e.width*e.height)}async#u(t,{params:e,tableGroup:i},a,n,o,r){this.device.queue.writeBuffer(e,0,a);let l=this.#t(n),c=this.device.createBuffer({size:16*r,usage:GPUBufferUsage.STORAGE|GPUBufferUsage.COPY_SRC}),h=this.device.createCommandEncoder(),u=h.beginComputePass();u.setPipeline(t),u.setBindGroup(0,this.#n(this.numberGroup,[e,l,c])),i&&u.setBindGroup(1,i),u.dispatchWorkgroups(Math.ceil(o/64)),u.end(),this.device.queue.submit([h.finish()]);let d=await this.#o(c,16*r);return l.destroy(),c.destroy(),d}async rows(t,e,i){await this.#e(t);let a=i.length/12;return this.#u(t.rows,t,e,i,a,2*a)}async albedo(t,e,i){return t.albedo??=await(t.albedoComing??=this.#a(t,Te)),this.#u(t.albedo,t,e,i,i.length/4,i.length/4)}};var js={A:0,B:1,wipe:2,side:3,diff:4},Gs={none:0,reinhard:1,filmic:2};function Be({canvas:s,mode:t,wipe:e,exposure:i,tone:a,a:n,b:o}){let r=new Float32Array(16);return r.set([js[t],e,n.width,n.height],0),r.set([2**i,Gs[a],o.width,o.height],4),r.set([1/n.samples,1/o.samples,0,0],8),r.set([s.width,s.height,0,0],12),r}var qs={both:0,model:1,light:2},Hs=8;function Ce({width:s,height:t,sample:e,seed:i=1,view:a,light:n,furnace:o,scene:r,estimator:l="both",depth:c}){let h=new Float32Array(176),u=(k,...M)=>h.set(M,4*k),{origin:d,forward:g,right:m,up:f,half:v,aspect:w}=a;u(0,s,t,e,i),u(1,...d,v),u(2,...m,w),u(3,...f,o?1:0),u(4,...g,c??(o?256:12));let $=o?[]:n.lamps.slice(0,Hs),b=!o&&n.picture;u(5,...o?[1,1,1]:b?[1,1,1].map(k=>k*(n.scale??1)):n.surround,b?1:0);let y=(n.turn??0)*Math.PI/180;return u(6,Math.cos(y),Math.sin(y),$.length,b?$.length?.5:1:0),u(7,0,r.count,...o?[0,0]:n.fade),u(11,...n.groundColour??[0,0,0],0),u(8,...r.core?.centre??[0,0,0],r.core?.radius??0),u(9,0,0,qs[l],0),b&&u(10,b.width,b.height,0,0),$.forEach((k,M)=>{u(12+4*M,...k.centre,k.shape==="disk"?1:0),u(13+4*M,...k.a,k.area),u(14+4*M,...k.b,0),u(15+4*M,...k.radiance,k.area*(.2126*k.radiance[0]+.7152*k.radiance[1]+.0722*k.radiance[2]))}),h}function Le(s){let t=s.reduce((m,f)=>m+f.faces.length/3,0),e=new Float32Array(3*t),i=new Float32Array(3*t),a=new Float32Array(3*t),n=new Float32Array(12*Math.max(t,1)),o=new Float32Array(20*Math.max(t,1)),r=new Uint32Array(t),l=[],c=0;for(let m of s)for(let f=0;f<m.faces.length;f+=3,c++){r[c]=c,l.push([m,f]);for(let v=0;v<3;v++){let[w,$,b]=[0,1,2].map(y=>m.positions[3*m.faces[f+y]+v]);e[3*c+v]=Math.min(w,$,b),i[3*c+v]=Math.max(w,$,b),a[3*c+v]=(e[3*c+v]+i[3*c+v])/2}}let h=[],u=(m,f)=>{let v=[1/0,1/0,1/0,-1/0,-1/0,-1/0];for(let w=m;w<f;w++)Re(v,e,i,r[w]);return v},d=(m,f,v,w)=>{let $=u(f,v);if(h[m]=[$,f,v-f],v-f<=4||w>=36)return;let b=Ws(e,i,a,r,f,v),y=f;if(b){for(let M=f;M<v;M++)if(a[3*r[M]+b.axis]<b.at){let x=r[M];r[M]=r[y],r[y++]=x}}if(y===f||y===v){if(v-f<=16)return;y=f+v>>1}let k=h.length;h.push(null,null),h[m]=[$,k,0],d(k,f,y,w+1),d(k+1,y,v,w+1)};t&&(h.push(null),d(0,0,t,0));let g=new Float32Array(8*Math.max(h.length,1));h.forEach(([m,f,v],w)=>g.set([m[0],m[1],m[2],f,m[3],m[4],m[5],v],8*w));for(let m=0;m<t;m++)Vs(n,o,m,...l[r[m]]);return{nodes:g,places:n,looks:o,count:h.length,triangles:t}}function Re(s,t,e,i){for(let a=0;a<3;a++)s[a]=Math.min(s[a],t[3*i+a]),s[3+a]=Math.max(s[3+a],e[3*i+a])}var Ie=s=>{let[t,e,i]=[s[3]-s[0],s[4]-s[1],s[5]-s[2]];return t<0?0:t*e+e*i+i*t},se=()=>[1/0,1/0,1/0,-1/0,-1/0,-1/0];function Ws(s,t,e,i,a,n){let o=null,r=1/0;for(let l=0;l<3;l++){let c=1/0,h=-1/0;for(let f=a;f<n;f++){let v=e[3*i[f]+l];c=Math.min(c,v),h=Math.max(h,v)}if(!(h>c))continue;let u=Array.from({length:16},()=>({box:se(),count:0}));for(let f=a;f<n;f++){let v=u[Math.min(15,Math.floor((e[3*i[f]+l]-c)/(h-c)*16))];Re(v.box,s,t,i[f]),v.count++}let d=[],g=se(),m=0;for(let f=15;f>0;f--)Ne(g,u[f].box),m+=u[f].count,d[f]=Ie(g)*m;g=se(),m=0;for(let f=1;f<16;f++){Ne(g,u[f-1].box),m+=u[f-1].count;let v=Ie(g)*m+d[f];v<r&&(r=v,o={axis:l,at:c+(h-c)*f/16})}}return o}function Ne(s,t){for(let e=0;e<3;e++)s[e]=Math.min(s[e],t[e]),s[3+e]=Math.max(s[3+e],t[3+e])}function Vs(s,t,e,i,a){let n=[0,1,2].map(h=>i.faces[a+h]),o=h=>[0,1,2].map(u=>i.positions[3*n[h]+u]),[r,l,c]=[o(0),o(1),o(2)];s.set([...r,i.kind,l[0]-r[0],l[1]-r[1],l[2]-r[2],0,c[0]-r[0],c[1]-r[1],c[2]-r[2],0],12*e);for(let h=0;h<3;h++){let u=i.growth?i.growth[n[h]]:.5;t.set([i.normals[3*n[h]],i.normals[3*n[h]+1],i.normals[3*n[h]+2],u],20*e+4*h),i.uvs&&t.set([i.uvs[2*n[h]],i.uvs[2*n[h]+1]],20*e+12+2*h)}}function Fe({nodes:s,places:t,count:e},i,a){if(!e)return null;let n=null,o=1/0,r=a.map(c=>1/(Math.abs(c)<1e-12?1e-12:c)),l=[0];for(;l.length;){let c=8*l.pop(),h=0,u=o;for(let m=0;m<3;m++){let f=(s[c+m]-i[m])*r[m],v=(s[c+4+m]-i[m])*r[m];h=Math.max(h,Math.min(f,v)),u=Math.min(u,Math.max(f,v))}if(h>u*(1+1e-6))continue;let d=s[c+3],g=s[c+7];if(!g){l.push(d,d+1);continue}for(let m=d;m<d+g;m++){let f=12*m,[v,w]=[[t[f+4],t[f+5],t[f+6]],[t[f+8],t[f+9],t[f+10]]],$=j(a,w),b=E(v,$);if(Math.abs(b)<1e-14)continue;let y=[i[0]-t[f],i[1]-t[f+1],i[2]-t[f+2]],k=E(y,$)/b,M=j(y,v),x=E(a,M)/b,P=E(w,M)/b;k>=0&&x>=0&&k+x<=1&&P>1e-4&&P<o&&(o=P,n={t:P,i:m,u:k,v:x})}}return n}var E=(s,t)=>s[0]*t[0]+s[1]*t[1]+s[2]*t[2],j=(s,t)=>[s[1]*t[2]-s[2]*t[1],s[2]*t[0]-s[0]*t[2],s[0]*t[1]-s[1]*t[0]],z=(s,t)=>s.map(e=>e*t),N=(s,t)=>s.map((e,i)=>e+t[i]),L=s=>z(s,1/Math.hypot(...s));var Ys=20;function De({azimuth:s,elevation:t,distance:e,target:i},a,n){let o=s*Math.PI/180,r=t*Math.PI/180,l=[Math.cos(r)*Math.sin(o),Math.sin(r),Math.cos(r)*Math.cos(o)],c=N(i,z(l,e)),h=z(l,-1),u=L(j(h,[0,1,0])),d=j(u,h),g=Math.tan(Ys*Math.PI/360)/Math.min(1,a/n);return{origin:c,forward:h,right:u,up:d,half:g,aspect:a/n}}function je({origin:s,forward:t,right:e,up:i,half:a,aspect:n},o,r){let l=z(e,(2*o-1)*n*a),c=z(i,(1-2*r)*a);return{o:s,d:L(N(t,N(l,c)))}}var Pt=(s,t)=>.2126*s[4*t]+.7152*s[4*t+1]+.0722*s[4*t+2];function Ge(s,t,e){let i=t*e,a=new Float64Array(i),n=0;for(let d=0;d<e;d++){let g=Math.sin((d+.5)/e*Math.PI);for(let m=0;m<t;m++){let f=0;for(let v=-1;v<=1;v++)for(let w=-1;w<=1;w++)f=Math.max(f,Pt(s,Math.min(e-1,Math.max(0,d+v))*t+(m+w+t)%t));n+=a[d*t+m]=(.5*f+.5*Pt(s,d*t+m))*g}}let o=new Float32Array(4*i);if(!(n>0))return o;let r=a.map(d=>d*i/n),l=[],c=[],h=new Float64Array(i).fill(1),u=new Uint32Array(i);for(let d=0;d<i;d++)(r[d]<1?l:c).push(d);for(;l.length&&c.length;){let d=l.pop(),g=c[c.length-1];h[d]=r[d],u[d]=g,r[g]+=r[d]-1,r[g]<1&&l.push(c.pop())}for(let d=0;d<i;d++){let g=Math.sin((Math.floor(d/t)+.5)/e*Math.PI);o.set([h[d],u[d],a[d]/n*i/(2*Math.PI*Math.PI*g),0],4*d)}return o}function qe(s,t,e){let i=0;for(let o=0;o<t*e;o++)Pt(s,o)>Pt(s,i)&&(i=o);let a=(Math.floor(i/t)+.5)/e*Math.PI,n=(i%t+.5)/t*2*Math.PI;return[-Math.sin(a)*Math.sin(n),Math.cos(a),Math.sin(a)*Math.cos(n)]}function He({pixels:s,width:t,height:e},i,{band:a,reach:n,albedo:o}){let r=[0,0,0],l=[0,0,0];for(let m=0;m<e;m++){let f=(m+.5)/e*Math.PI,v=Math.cos(f)*Math.sin(f)*(Math.PI/e)*(2*Math.PI/t);if(v>0)for(let w=0;w<t;w++)for(let $=0;$<3;$++)r[$]+=s[4*(m*t+w)+$]*v}let[c,h]=a.map(m=>Math.floor(e*(90+m)/180)),u=t/2+i/360*t,d=t*n/360,g=0;for(let m=c;m<Math.max(h,c+1);m++)for(let f=Math.floor(u-d);f<=Math.floor(u+d);f++,g++)for(let v=0;v<3;v++)l[v]+=s[4*(m*t+(f%t+t)%t)+v];return l.map((m,f)=>Math.min(o[1],Math.max(o[0],Math.PI*m/g/Math.max(r[f],1e-12))))}var We=220,Xs=12,Js=90,Ks=8,Zs=1.14;async function Tt(s,t=""){let e="";if(t!=="webgl2")try{return{gpu:await Ut.create(),reason:e}}catch(a){e=a.message}let{create:i}=await s.part("webgl2");return{gpu:i({display:ut,members:Y,modelAt:ee,rows:ft,sources:mt,tableRows:At,trace:dt}),reason:e}}function ie(s,t){let e=I(s.positions,Uint16Array),i=I(s.normals,Int16Array),a=I(s.uvs,Int16Array);return{kind:t,faces:I(s.faces,Uint16Array),positions:Float32Array.from(e,(n,o)=>s.low[o%3]+n/65535*(s.high[o%3]-s.low[o%3])),normals:Float32Array.from(i,n=>n/32767),uvs:Float32Array.from(a,n=>n/32767*s.uv_reach),growth:s.growth?Float32Array.from(I(s.growth,Uint8Array),n=>n/255):null}}var zt=class{constructor(t,e,i){this.gpu=t,this.start=e,this.changed=i,this.sides=[],this.limit=256,this.size=[300,200],this.ms=0,this.epoch=0,this.movedAt=-1/0,this.own=null,this.sky=null,this.scenes=new Map,this.rate=400,this.settings=null}replace(t){this.gpu=t,this.sceneName=this.skyName="";for(let e of this.sides)e.film=null,e.program=null,e.samples=0}light(t){if(t.env==="own"&&this.sky){let{fade:i}=this.start,a=t.turn-t.az;return this.sky.groundFor!==a&&Object.assign(this.sky,{groundFor:a,ground:He(this.sky,a,i)}),{lamps:[],surround:[0,0,0],picture:this.sky,ground:null,fade:i.radii,groundColour:this.sky.ground,turn:t.turn}}let e=this.start.environments[t.env]??this.start.environments.studio;return{...e,fade:e.groundColour?this.start.fade.radii:[0,0],turn:t.turn}}#t(t,e){let i=t.furnace,a=t.shape==="own"&&!this.own?"ball":t.shape,n=`${a}/${i?"none":e.ground}/${this.own?.id}`;if(!this.scenes.has(n)){let{shapes:r}=this.start,l=[],c=null;a==="ball"?(l.push(ie(r.shell,0)),c=r.core,i||l.push(ie(r.pedestal,2))):a==="sphere"?c={centre:[0,i?1.2:1,0],radius:1}:l.push(this.own.mesh),!i&&e.ground&&l.push(ie(r.grounds[e.ground],1)),this.scenes.size>6&&this.scenes.clear(),this.scenes.set(n,{...Le(l),core:c,name:n})}let o=this.scenes.get(n);return this.sceneName!==n&&(this.gpu.setScene(o),this.sceneName=n),o}prepare(t){let e=this.light(t);this.#t(t,e),this.#s(e)}#s(t){if(!t.picture)return null;if(!t.picture.pixels){let{width:e,height:i,half:a}=t.picture,n=St(I(a,Uint16Array)),o=new Float32Array(4*e*i);for(let r=0;r<e*i;r++)o.set(n.subarray(3*r,3*r+3),4*r);t.picture.pixels=o}return t.picture.alias??=Ge(t.picture.pixels,t.picture.width,t.picture.height),t.picture.id??=crypto.randomUUID?.()??String(Math.random()),this.skyName!==t.picture.id&&(this.gpu.setSky(t.picture),this.skyName=t.picture.id),t.picture}lightDirection(t,e){let i=this.light(t),a=t.turn*Math.PI/180,n=([o,r,l])=>[Math.cos(a)*o+Math.sin(a)*l,r,Math.cos(a)*l-Math.sin(a)*o];if(i.lamps.length){let o=l=>l.radiance[1]*l.area/Math.hypot(...l.centre)**2,r=i.lamps.reduce((l,c)=>o(c)>o(l)?c:l);return n(r.centre).map((l,c)=>l-e[c])}return i.picture?(this.#s(i),n(qe(i.picture.pixels,i.picture.width,i.picture.height))):[.4,1,.5]}target(t){return t.shape==="sphere"?[0,t.furnace?1.2:1,0]:t.shape==="own"&&this.own?[0,this.own.height/2,0]:[0,t.furnace?1.2:Zs,0]}view(t,e,i){return De({azimuth:t.az,elevation:t.el,distance:t.dist,target:this.target(t)},e,i)}pictureSize(t=this.settings){let[e,i]=this.size;return t.cmp==="side"&&this.sides.length>1?[Math.floor(e/2),i]:[e,i]}restart(t,{moving:e=!0}={}){this.settings=t,this.epoch++,this.movedAt=e?performance.now():-1/0,this.#e?.()}refresh(t){this.settings=t,this.show(),this.#e?.()}#e=null;visible(){let{cmp:t}=this.settings,e=this.sides.filter(i=>i.program);return t==="A"||this.sides.length<2?e.slice(0,1):t==="B"?e.slice(1):e}show(){let[t,e]=this.sides,i=this.settings;if(!i)return;let a=h=>!!h?.film?.width;if((!e||i.cmp==="A"?[t]:i.cmp==="B"?[e]:[t,e]).some(h=>!a(h)&&!h.error))return;let o=a(t)?t:e;if(!a(o))return;let r=a(e)?e:o,l=h=>({width:h.film.width,height:h.film.height,samples:Math.max(1,h.shown)}),c=this.sides.length<2?"A":i.cmp==="flick"?this.flicker?"B":"A":i.cmp;this.gpu.show(o.film,r.film,Be({canvas:this.gpu.canvas,mode:c,wipe:i.wipe,exposure:i.ev,tone:i.tone,a:l(o),b:l(r)}))}async run(){for(;!this.closed;){let t=performance.now(),e=!!this.settings&&t-this.movedAt<We,i=this.settings?this.visible():[],a=e?this.#a(i.length):1,n=i.filter(c=>c.epoch!==this.epoch||c.scale!==a||c.samples<(e?4:this.limit));if(!n.length||this.paused){let c=e?We-(t-this.movedAt)+1:0;await new Promise(h=>{this.#e=h,(c>0||this.paused)&&setTimeout(h,this.paused?200:c)});continue}let o=Math.min(...n.map(c=>c.epoch===this.epoch&&c.scale===a?c.samples:0)),r=n.filter(c=>c.epoch!==this.epoch||c.scale!==a||c.samples===o),l=[];try{for(let c of r){let h=await this.#i(c,a,e);if(!h)break;l.push(h)}l.length===r.length&&this.#n(l)}catch(c){this.closed||this.failed?.(c),await new Promise(h=>setTimeout(h,500))}}}#a(t){let[e,i]=this.pictureSize(),a=this.coarse??4,n=Math.sqrt(e*i*t/(this.rate*Js));return this.coarse=Math.min(Ks,Math.max(2,n>a*1.3||n<a*.6?Math.ceil(n):a)),this.coarse}async#i(t,e,i){let{epoch:a,settings:n}=this,{program:o}=t,r=this.light(n),l=this.#s(r),c=this.#t(n,r),[h,u]=this.pictureSize(n).map(w=>Math.max(1,Math.floor(w/e))),d=t.epoch!==a||t.scale!==e||t.film?.wanted?.[0]!==h||t.film?.wanted?.[1]!==u;t.film??=this.gpu.makeSide(),(t.mapsOf!==t.payload||t.mapsOn!==t.film)&&(t.mapData=t.maps(),this.gpu.setMaps(t.film,t.mapData),t.mapsOf=t.payload,t.mapsOn=t.film),d&&this.gpu.resize(t.film,h,u);let g=d?0:t.samples,m=Ce({width:h,height:u,sample:g,view:this.view(n,h,u),light:{...r,picture:l},furnace:n.furnace,scene:c,estimator:this.estimator??"both"}),f=t.packed(),v=0;for(let w=0;w<u;){let $=Math.max(8,Math.round(this.rate*Xs/h/8)*8),b=Math.min(u,w+$),y=performance.now();await this.gpu.trace(t.film,o,f,m,w,b);let k=Math.max(performance.now()-y,.2);if(v+=k,this.rate+=.3*(Math.min(h*(b-w)/k,1e6)-this.rate),w=b,this.closed||t.program!==o||!i&&this.epoch!==a)return null}return{side:t,epoch:a,scale:e,samples:g+1,spent:v}}#n(t){for(let{side:e,epoch:i,scale:a,samples:n}of t)this.gpu.swap(e.film),Object.assign(e,{epoch:i,scale:a,samples:n,shown:n});this.begun||performance.mark("gonio-picture"),this.begun=!0,this.ms=t.reduce((e,{spent:i})=>e+i,0),this.show(),this.changed(t[0].side)}async statistics(){let t=[];for(let n of this.visible()){if(!n.film?.width||n.shown<2)return null;t.push({side:n,n:n.shown,width:n.film.width,data:await this.gpu.readFilm(n.film)})}let e=(n,o)=>.2126*n[o]+.7152*n[o+1]+.0722*n[o+2],i=t.map(({side:n,n:o,data:r})=>{let l=0,c=0;for(let u=0;u<r.length;u+=4){let d=e(r,u)/o;l+=d,c+=Math.sqrt(Math.max(0,r[u+3]/o-d*d)/o)}let h=r.length/4;return{letter:n.letter,mean:l/h,noise:c/Math.max(l,1e-9)}}),a=null;if(t.length===2&&t[0].data.length===t[1].data.length){let n=0,[o,r]=t;for(let l=0;l<o.data.length;l+=4)for(let c=0;c<3;c++)n+=(o.data[l+c]/o.n-r.data[l+c]/r.n)**2;a=Math.sqrt(n/(.75*o.data.length))}return{sides:i,rmse:a}}close(){this.closed=!0,this.#e?.(),this.gpu.close()}};function Ve(s,t,e,i){let[a,n]=s.pictureSize(t),o=s.view(t,a,n),{o:r,d:l}=je(o,e,i),c=s.scenes.get(s.sceneName);if(!c)return null;let h=Fe(c,r,l),u=h?.t??1/0,d=!1;if(c.core){let x=c.core.centre.map((J,T)=>J-r[T]),P=E(x,l),R=N(x,z(l,-P)),O=c.core.radius**2-E(R,R);O>0&&P-Math.sqrt(O)>0&&P-Math.sqrt(O)<u&&(u=P-Math.sqrt(O),d=!0)}if(!Number.isFinite(u))return null;let g=N(r,z(l,u)),m,f,v,w=.5;if(d)m=L(N(g,z(c.core.centre,-1))),f=[-m[2],0,m[0]],v=[(Math.atan2(-m[0],-m[2])/(2*Math.PI)+1)%1,Math.acos(m[1])/Math.PI];else{let x=h.i,{places:P,looks:R}=c;if(P[12*x+3]!==0)return null;let O=[1-h.u-h.v,h.u,h.v],J=C=>O[0]*R[20*x+C]+O[1]*R[20*x+4+C]+O[2]*R[20*x+8+C];m=L([J(0),J(1),J(2)]),w=J(3);let T=[0,1,2].map(C=>[R[20*x+12+2*C],R[20*x+13+2*C]]);v=[0,1].map(C=>O[0]*T[0][C]+O[1]*T[1][C]+O[2]*T[2][C]);let ks=[...P.subarray(12*x+4,12*x+7)],Ms=[...P.subarray(12*x+8,12*x+11)],Dt=[T[1][0]-T[0][0],T[1][1]-T[0][1]],jt=[T[2][0]-T[0][0],T[2][1]-T[0][1]];f=z(N(z(ks,jt[1]),z(Ms,-Dt[1])),Math.sign(Dt[0]*jt[1]-Dt[1]*jt[0]))}E(m,l)>0&&(m=z(m,-1)),f=N(f,z(m,-E(f,m)));let $=E(f,f)>1e-16?L(f):L(j(Math.abs(m[1])>.99?[1,0,0]:[0,1,0],m)),b=j(m,$),y=x=>[E(x,$),E(x,b),E(x,m)],k=y(z(l,-1)),M=y(L(s.lightDirection(t,g)));return M[2]<=0&&(M=[-k[0],-k[1],k[2]]),{p:g,t:u,uv:v,growth:w,wi:M,wo:k}}var vt=s=>String(Number(s.toPrecision(9))),Ye=s=>Array.isArray(s)?s.every(t=>t===s[0])?vt(s[0]):s.map(vt).join("/"):typeof s=="number"?vt(s):s,gt=class{constructor(t){this.letter=t,this.payload=null,this.values=new Map,this.samples=0,this.error="",this.busy="",this.hidden=new Set,this.active=null}take(t){this.payload=t,this.values=new Map(t.parameters.map(e=>[e.path,e.value.slice()])),this.options=new Map(t.options.map(e=>[e.path,e.value])),this.models=new Map(t.models.map(e=>[e.path,e.value]))}parameter(t){return this.payload.parameters.find(e=>e.path===t)}startOf(t,e){let i=this.payload.start[t],a=t.lastIndexOf(".");for(let o=t.slice(0,Math.max(a,0));o;o=o.slice(0,Math.max(o.lastIndexOf("."),0)))if(this.models.get(o)!==this.payload.start[o])return e;if(i===void 0)return e;let n=Array.isArray(e)?e.length:0;return n?Array.isArray(i)?i:Array(n).fill(i):i}changed(t){let e=this.parameter(t),i=e?this.startOf(t,e.default):null;return e?this.values.get(t).some((a,n)=>vt(a)!==vt(i[n])):!1}text(t={}){let e=[],i=a=>Object.keys(t).some(n=>a.startsWith(`${n}.`)&&this.models.has(n)&&t[n]!==this.models.get(n));for(let[a,n]of this.models){let o=t[a]??n,r=this.payload.models.find(l=>l.path===a);!i(a)&&o!==this.startOf(a,r.default)&&e.push(`${a}=${o}`)}for(let a of this.payload.options){let n=t[a.path]??this.options.get(a.path);!i(a.path)&&n!==this.startOf(a.path,a.default)&&e.push(`${a.path}=${n}`)}for(let a of this.payload.parameters)!i(a.path)&&this.changed(a.path)&&e.push(`${a.path}=${Ye(this.values.get(a.path))}`);return this.payload.name+(e.length?`:${e.join(",")}`:"")}plainText(){let{payload:t}=this;if(t.name===t.model||t.name.endsWith(".py")||t.foreign)return this.text();if(this.text()===t.name&&t.plain)return t.name;let e=t.models.filter(i=>this.models.get(i.path)!==i.default).map(i=>`${i.path}=${this.models.get(i.path)}`);for(let i of t.options)this.options.get(i.path)!==i.default&&e.push(`${i.path}=${this.options.get(i.path)}`);for(let i of t.parameters)this.values.get(i.path).some((a,n)=>a!==i.default[n])&&e.push(`${i.path}=${Ye(this.values.get(i.path))}`);return t.model+(e.length?`:${e.join(",")}`:"")}packed(t={}){let{members:e}=this.active.payload,i=new Float32Array(4*Math.max(1,e.length));return e.map(this.active.path).forEach((a,n)=>i.set(t[a]??this.values.get(a),4*n)),i}maps(){let{maps:t}=this.payload;if(!t)return{size:1,layers:1,pixels:new Float32Array(4)};let e=St(I(t.half,Uint16Array)),i=e.length/t.channels,a=new Float32Array(4*i);for(let n=0;n<i;n++)for(let o=0;o<t.channels;o++)a[4*n+o]=e[t.channels*n+o];return{size:t.size,layers:t.layers,pixels:a}}overrides(t,e,i,a){let n={};for(let o of this.payload.hooks)if(o.source==="mesh")n[o.path]=[e];else if(o.source==="viewer")n[o.path]=[i/o.unit];else if(o.source!=="normal_map"){let r=o.source==="flakes"?[o.tiles,o.tiles]:o.scale,{size:l,pixels:c}=a,h=t.map((w,$)=>w*r[$]*l-(o.source==="flakes"?0:.5)),u=(w,$,b)=>c[4*((o.layer*l+($%l+l)%l)*l+(w%l+l)%l)+b],[d,g]=h.map(Math.floor),[m,f]=[h[0]-d,h[1]-g],v=w=>o.source==="flakes"?u(d,g,w):(1-f)*((1-m)*u(d,g,w)+m*u(d+1,g,w))+f*((1-m)*u(d,g+1,w)+m*u(d+1,g+1,w));n[o.path]=o.width===3?[v(0),v(1),v(2)]:[v(o.channel)]}return n}};var tt={a:"",b:"",cmp:"A",wipe:.5,env:"studio",turn:0,ev:0,tone:"none",furnace:!1,shape:"ball",view:"picture",az:0,el:13,dist:9.6,theta:45,layer:0,probe:"",dock:"plots",edit:"A"},Qs={cmp:["A","B","wipe","side","flick","diff"],tone:["none","reinhard","filmic"],shape:["ball","sphere"],view:["picture","lobe","slices","map","albedo","weights"],dock:["plots","code","about"]},ti={wipe:[0,1],turn:[-180,180],ev:[-20,20],az:[-180,180],el:[-85,85],dist:[2.5,40],theta:[0,89],layer:[0,99]},Xe=s=>typeof tt[s]=="number";function Ot(s){let t=[];for(let[e,i]of Object.entries(tt)){let a=s[e];if(a===i&&!(e==="cmp"&&s.b)||e==="edit"||a==="own")continue;let n=Xe(e)?String(Math.round(a*1e4)/1e4):a===!0?"1":a;t.push(`${e}=${encodeURIComponent(String(n).toWellFormed?.()??n).replace(/%3A/g,":").replace(/%3D/g,"=").replace(/%2C/g,",").replace(/%2F/g,"/")}`)}return t.join("&")}function Bt(s){let t={},e=[];for(let i of s.replace(/^#/,"").split("&").filter(Boolean)){let a=i.indexOf("="),n=a<0?i:i.slice(0,a),o="";try{o=decodeURIComponent(a<0?"":i.slice(a+1))}catch{e.push(n);continue}if(n!=="token"){if(!Object.hasOwn(tt,n)){e.push(n);continue}if(Xe(n)){if(o.trim()===""||!Number.isFinite(Number(o))){e.push(n);continue}o=Number(o)}else typeof tt[n]=="boolean"&&(o=o==="1");t[n]=o}}return{state:t,bad:e}}var Et=class{constructor(t){this.steps=[JSON.stringify(t)],this.at=0,this.name=""}add(t,e){let i=JSON.stringify(t),a=Date.now();i!==this.steps[this.at]&&(e&&e===this.name&&a-this.when<1e3?this.steps[this.at]=i:(this.steps.splice(++this.at,1/0,i),this.steps.length>200&&(this.steps.shift(),this.at--)),this.name=e,this.when=a)}step(t){return this.can(t)?(this.at+=t,this.name="",JSON.parse(this.steps[this.at])):null}can(t){return this.at+t>=0&&this.at+t<this.steps.length}},ei=s=>{let t=s.split(",");return t.length===2&&t.every(e=>e.trim()&&e>=0&&e<=1)};function Je(s,t,e){let i={...Qs,env:Object.keys(t)};for(let[a,n]of Object.entries(i))a in s&&!n.includes(s[a])&&(e.push(a),delete s[a]);s.probe&&!ei(s.probe)&&(e.push("probe"),delete s.probe);for(let[a,[n,o]]of Object.entries(ti))a in s&&!(s[a]>=n&&s[a]<=o)&&(e.push(a),delete s[a]);return s}var wt=s=>s<=.0031308?12.92*Math.max(s,0):1.055*Math.min(s,1)**.4166666666666667-.055,Ke=s=>s<=.04045?s/12.92:((s+.055)/1.055)**2.4,G=s=>`rgb(${s.map(t=>Math.round(255*wt(t))).join(" ")})`,$t=s=>`#${s.map(t=>Math.round(255*wt(t)).toString(16).padStart(2,"0")).join("").toUpperCase()}`;function Ze(s){let t=/^#?([0-9a-f]{6}|[0-9a-f]{3})$/i.exec(s.trim());if(!t)return null;let e=t[1].length===3?[...t[1]].map(i=>i+i).join(""):t[1];return[0,2,4].map(i=>Ke(parseInt(e.slice(i,i+2),16)/255))}function Qe(s){let[t,e,i]=s.map(wt),a=Math.max(t,e,i),n=a-Math.min(t,e,i);return[(n===0?0:a===t?((e-i)/n+6)%6:a===e?(i-t)/n+2:(t-e)/n+4)*60,a===0?0:n/a,a]}function ae([s,t,e]){let i=a=>{let n=(a+s/60)%6;return e-e*t*Math.max(0,Math.min(n,4-n,1))};return[i(5),i(3),i(1)].map(Ke)}var ts=180/Math.PI;function B(s){if(s===0)return"0";let t=Math.abs(s);return t<.001||t>=1e5?s.toExponential(2).replace(/\.?0+e/,"e").replace("e+","e"):String(Number(s.toFixed(t<.1?4:t<10?3:t<100?2:1)))}var S=(s,t=4)=>Number.isFinite(s)?s.toFixed(t).replace("-","−"):"–",et=(s,t)=>s.kind==="angle"?t*ts:t,ii=(s,t)=>s.kind==="angle"?t/ts:t,bt=s=>s.kind==="angle"?"°":"";function Ct(s,t){let e=s.scale==="log"?Math.log(Math.max(t,s.soft_low)/s.soft_low)/Math.log(s.soft_high/s.soft_low):(t-s.soft_low)/(s.soft_high-s.soft_low);return Math.max(0,Math.min(1,e))}function It(s,t){if(t<=0)return s.scale==="log"?s.low:s.soft_low;if(t>=1)return s.soft_high;let e=s.scale==="log"?s.soft_low*(s.soft_high/s.soft_low)**t:s.soft_low+t*(s.soft_high-s.soft_low);return Number(e.toPrecision(4))}function ne(s){let t=e=>B(et(s,e))+bt(s);return s.high===null?`at least ${t(s.low)}`:`${t(s.low)} to ${t(s.high)}`}function es(s,t){let e=Number(t.replace("−","-").replace(",",".").replace("°","").trim());if(t.trim()===""||!Number.isFinite(e))return{error:`${t.trim()||"Nothing"} is no number.`};let i=ii(s,e),a=1e-7*Math.max(1,Math.abs(i));return i<s.low-a||s.high!==null&&i>s.high+a?{error:`Allowed is ${ne(s)}.`}:{value:Math.max(s.low,s.high===null?i:Math.min(s.high,i))}}function ss(s){let t=[];for(let e=Math.ceil(Math.log10(s.soft_low)-1e-9);e<=Math.log10(s.soft_high)+1e-9;e++){let i=[...String(e)].map(a=>a==="-"?"⁻":"⁰¹²³⁴⁵⁶⁷⁸⁹"[a]).join("");t.push({at:Ct(s,10**e),text:e<-2||e>3?`10${i}`:String(Number((10**e).toFixed(3))).replace(/^0\./,".")})}return t}var Nt=Math.PI/180,oe=["red","green","blue","luminance"],st=(s,t)=>t===3?.2126*s[0]+.7152*s[1]+.0722*s[2]:s[t],X=s=>s.map(([t,e],i)=>`${i?"L":"M"}${t.toFixed(1)} ${e.toFixed(1)}`).join(""),Lt=(s,t)=>_`<path d=${s} fill="none" stroke=${t==="A"?"var(--a)":"var(--b)"} stroke-width="1.75" stroke-linejoin="round" stroke-dasharray=${t==="A"?"none":"5 3"}></path>`,is=s=>s>=-2&&s<=3?String(Number((10**s).toFixed(3))):`10${[...String(s)].map(t=>t==="-"?"⁻":"⁰¹²³⁴⁵⁶⁷⁸⁹"[t]).join("")}`;function Rt(s,t,e,i){let{width:a=300,height:n=150}=s.sizes[t]??{};return p`<svg class="p" data-chart=${t} viewBox=${`0 0 ${a} ${n}`} role="img" aria-label=${e}>${i(a,n)}</svg>`}function re(s,t,e,i){let a=Math.min(e/2-34,i-30),n=e/2,o=i-20,r=s.flatMap(({slice:$})=>$.map(b=>st(b.f,t)*Math.cos(b.angle*Nt))).filter($=>$>0&&Number.isFinite($)),l=Math.ceil(Math.log10(Math.max(1e-6,...r))+1e-9),c=Math.min(4,Math.max(3,l+2)),h=l-c,u=$=>$>0?Math.max(0,(Math.log10($)-h)/c)*a:0,d=($,b)=>[n+b*Math.sin($*Nt),o-b*Math.cos($*Nt)],g=Array.from({length:c},($,b)=>b+1).map($=>{let b=$/c*a;return _`<path d=${`M${n-b} ${o}A${b} ${b} 0 0 1 ${n+b} ${o}`} fill="none" stroke="var(--line)"></path>${a/c>22||$%2===c%2?_`<text x=${n+b} y=${o+14} text-anchor="middle">${is(h+$)}</text>`:""}`}),m=[-60,-30,0,30,60].map($=>_`<path d=${X([[n,o],d($,a)])} stroke="var(--line)"></path>${$?_`<text x=${d($,a+14)[0]} y=${d($,a+14)[1]+4} text-anchor="middle">${$<0?"−":""}${Math.abs($)}°</text>`:""}`),f=s[0]?.thetaO??45,[v,w]=d(-f,a);return _`${g}${m}<path d=${`M${n-a} ${o}H${n+a}`} stroke="var(--edge)"></path>
        ${s.map(({letter:$,slice:b})=>Lt(X(b.map(y=>d(y.angle,u(st(y.f,t)*Math.cos(y.angle*Nt))))),$))}
        <path d=${X([[n,o],[v,w]])} stroke="var(--text)" stroke-width="1.25" stroke-dasharray="2 3"></path><text x=${v+16} y=${w+4} class="strong">ωo</text>`}function le({x0:s,x1:t,y1:e,ticks:i,log:a=!1,xs:n=[0,30,60,90]},o,r){return _`${i.map(l=>_`<path d=${`M${s} ${r(l)}H${t}`} stroke=${l===1&&!a?"var(--edge)":"var(--line)"}></path><text x=${s-8} y=${r(l)+4} text-anchor="end">${a?is(Math.round(Math.log10(l))):Number(l.toFixed(3))}</text>`)}
        ${n.map(l=>_`<text x=${o(l)} y=${e+16} text-anchor="middle">${l<0?"−":""}${Math.abs(l)}°</text>`)}`}function ce(s,t,e,i,a){let[n,o,r,l]=[34,e-62,8,i-22],c=Math.max(1,...s.flatMap(w=>w.albedo.map($=>st($.value,t))).filter(Number.isFinite)),h=c<=1.02?1.1:Math.ceil(c*2+.1)/2,u=h>4?Math.ceil(h/4):h>1.6?1:.5,d=w=>n+(o-n)*w/90,g=w=>l-(l-r)*Math.min(w,h)/h,m=Array.from({length:Math.floor(h/u+1e-6)+1},(w,$)=>$*u),f=[],v=s.map(({letter:w,albedo:$})=>{let b=$.map(x=>[x.angle,st(x.value,t)]),y=b.filter(([,x])=>x>1.0005),k=b[b.length-1][1],M=g(k)+4;for(let x of f)Math.abs(x-M)<14&&(M=x+(M>=x?14:-14));return f.push(M),_`${y.length?_`<path fill="var(--warn)" opacity=".28" d=${`${X([[d(y[0][0]),g(1)],...y.map(([x,P])=>[d(x),g(P)]),[d(y[y.length-1][0]),g(1)]])}Z`}></path><text x=${Math.min(d(y[0][0])-6,o-4)} y=${Math.max(g(1)-12,r+10)} text-anchor=${d(y[0][0])>n+150?"end":"start"} class="warn">${w} gains energy ${y[0][0]>0?`from ${Math.round(y[0][0])}°`:"everywhere"}</text>`:""}
            ${Lt(X(b.map(([x,P])=>[d(x),g(P)])),w)}<text x=${o+8} y=${M} class=${`of${w}`}>${w} ${S(k,2)}</text>`});return _`${le({x0:n,x1:o,y0:r,y1:l,ticks:m},d,g)}${v}
        ${a===null?"":_`<path d=${`M${d(a)} ${r}V${l}`} stroke="var(--text)" stroke-dasharray="2 3"></path><text x=${d(a)+(a>55?-6:6)} text-anchor=${a>55?"end":"start"} y=${r+10} class="strong">θo ${Math.round(a)}°</text>`}`}function as(s,t){s.width=s.height=D;let e=s.getContext("2d"),i=e.createImageData(D,D),a=t.filter(Boolean).map(o=>Math.max(...o)).filter(Number.isFinite).sort((o,r)=>o-r),n=Math.max(1e-9,a[Math.floor(.95*a.length)]??1);t.forEach((o,r)=>i.data.set(o?[...o.map(l=>Math.round(255*wt(Math.min(1,Math.max(0,l/n))))),255]:[0,0,0,0],4*r)),e.putImageData(i,0,0)}var he=["picture","lobe","slices","map","albedo","weights"];function ns(s){let t=s.options.keys??document,e=i=>{let a=i.composedPath()[0];if(a instanceof HTMLInputElement&&a.type!=="range"||a instanceof HTMLTextAreaElement||a instanceof HTMLSelectElement||i.altKey)return;let n=i.key.length===1?i.key.toLowerCase():i.key,o=s.two;if(i.ctrlKey||i.metaKey){n==="z"&&(i.preventDefault(),s.step(i.shiftKey?1:-1)),n==="y"&&(i.preventDefault(),s.step(1));return}let r=c=>()=>o&&s.set({cmp:c}),l={a:r("A"),b:r("B"),w:r("wipe"),s:r("side"),d:r("diff"),k:r("flick"),x:()=>s.swap(),c:()=>s.compare(),f:()=>s.set({furnace:!s.state.furnace}),l:()=>s.set({turn:(s.state.turn+195)%360-180},"turn"),"[":()=>s.set({ev:Math.round((s.state.ev-1/3)*1e3)/1e3},"ev"),"]":()=>s.set({ev:Math.round((s.state.ev+1/3)*1e3)/1e3},"ev"),p:()=>s.state.probe&&!s.pointer?s.set({probe:""}):s.pointer&&s.probe(...s.pointer),v:()=>s.set({view:he[(he.indexOf(s.state.view)+1)%he.length]}),"?":()=>{s.help=!s.help,s.update()},Escape:()=>{s.help=s.menu=!1,s.picking="",s.state.probe&&s.set({probe:""}),s.update()}};if(/^[1-9]$/.test(n)){s.set({layer:Number(n)-1});return}l[n]&&(i.preventDefault(),l[n]())};return t.addEventListener("keydown",e),()=>t.removeEventListener("keydown",e)}var ai={reset:"M3.5 8a4.5 4.5 0 1 0 1.6-3.4M3.5 2.5v3h3",undo:"M3 6h6.5a3.5 3.5 0 0 1 0 7H6M3 6l3-3M3 6l3 3",redo:"M13 6H6.5a3.5 3.5 0 0 0 0 7H10M13 6l-3-3M13 6l-3 3",swap:"M3 5h10l-2.5-2.5M13 11H3l2.5 2.5",light:"M8 5a3 3 0 1 0 0 6 3 3 0 0 0 0-6zM8 1v1.5M8 13.5V15M1 8h1.5M13.5 8H15M3 3l1 1M12 12l1 1M13 3l-1 1M4 12l-1 1",large:"M9.5 2.5h4v4M6.5 13.5h-4v-4M13.5 2.5L9 7M2.5 13.5L7 9",eye:"M1.5 8s2.4-4.5 6.5-4.5S14.5 8 14.5 8 12.1 12.5 8 12.5 1.5 8 1.5 8zM8 6.2a1.8 1.8 0 1 0 0 3.6 1.8 1.8 0 0 0 0-3.6z",closed:"M1.5 6.5S4 10.5 8 10.5s6.5-4 6.5-4M3.6 9.2L2.3 11M12.4 9.2l1.3 1.8M8 10.5v2.2",warn:"M8 2.2L14.5 13.5h-13zM8 6.5v3.2M8 11.6v.01",info:"M8 2a6 6 0 1 0 0 12A6 6 0 0 0 8 2zM8 7.3v3.4M8 5.2v.01",layers:"M8 2l6 3.2-6 3.2-6-3.2zM2 8.2l6 3.2 6-3.2M2 11l6 3.2 6-3.2",plots:"M2 2v12h12M4.5 10.5l3-4 2.5 2 3.5-5",code:"M5.5 4L1.5 8l4 4M10.5 4l4 4-4 4",wipe:"M5.5 4.5L2 8l3.5 3.5M10.5 4.5L14 8l-3.5 3.5",close:"M4 4l8 8M12 4l-8 8",more:"M3 8h.01M8 8h.01M13 8h.01",plus:"M8 3v10M3 8h10"},A=s=>_`<svg class="ic" viewBox="0 0 16 16" aria-hidden="true"><path d=${ai[s]}></path></svg>`;function q(s){let t=[{prefix:"",model:s.payload.model,child:null}];for(let[e,i]of s.models)t[t.length-1].child=e,t.push({prefix:`${e}.`,model:i,child:null});return t.forEach((e,i)=>{e.number=i+1,e.title=ni(s,e,t.length)}),t}function ni(s,t,e){let i=s.values.get(`${t.prefix}sigma_a`),a=s.values.get(`${t.prefix}thickness`);return t.child?i?.some(n=>n>0)&&a?.[0]!==0?"Tinted coat":"Clear coat":e>1?"Base":"Surface"}var oi=["eta","top_eta","alpha","roughness","sigma","shininess","metal_alpha","metallic"];function ri(s,t){let e=t.child?[]:[t.model];for(let i of oi){let a=s.values.get(t.prefix+i);a?.length===1&&e.length<3&&e.push(`${i} ${B(a[0])}`)}return e.join(" · ")}function os(s,{prefix:t,child:e}){let i=c=>s.values.get(t+c),a=i("sigma_a"),n=i("thickness")?.[0]??1;if(e){let c=a?a.map(h=>Math.exp(-2*h*n)):[1,1,1];return c.every(h=>h>.98)?"var(--cut1)":G(c)}let o=i("rho")??i("base_color");if(o)return G(o.map(c=>Math.max(c,.02)));let r=i("metal_eta")??i("eta"),l=i("metal_k")??i("k");return r?.length===3&&l?.length===3?G(r.map((c,h)=>((c-1)**2+l[h]**2)/((c+1)**2+l[h]**2))):i("f0")?G(i("f0")):"var(--edge)"}var rs=s=>{let t=s;return()=>(t=t*16807%2147483647)/2147483647};function li(s,t){let e=rs(t*7919+17);return Array.from({length:19},(i,a)=>`${a?"L":"M"}${4*a} ${(9+s*9*(e()-.5)).toFixed(1)}`).join("")}function ci(s,t){for(let e of["alpha","roughness","sigma","metal_alpha"]){let i=s.values.get(t+e);if(i)return Math.min(1,i[0])**.6}return .35}function hi(s,t,e){let i=li(ci(s,t.prefix),t.number),a=rs(99),n=t.child?[]:Array.from({length:26},()=>_`<circle cx=${(4+64*a()).toFixed(1)} cy=${(18+28*a()).toFixed(1)} r=${(.6+.7*a()).toFixed(1)} fill="#0003"></circle>`);return p`<svg viewBox="0 0 72 50" preserveAspectRatio="none" aria-hidden="true">${_`
        <path d="M0 0H72V50H0Z" fill=${e}></path><path d=${`${i}L72 50L0 50Z`} fill=${os(s,t)}></path>${n}
        <path d=${i} fill="none" stroke="#fff9" stroke-width="1.25"></path>`}</svg>`}function ls(s){let t=s.edited(),e=q(t),i="var(--air)",a=e.map((n,o)=>{let r=o===s.layerIndex(),l=t.hidden.has(n.prefix),c=hi(t,n,i);return i=os(t,n),p`<div class="lay ${l?"off":""} ${e.length>5&&!r?"thin":""}" ?data-on=${r}>${c}
            <button role="tab" aria-selected=${r} @click=${()=>s.set({layer:o})}><b>${n.number}&ensp;${n.title}</b><small>${ri(t,n)}</small></button>
            ${n.child?p`<button class="ib" aria-pressed=${l} aria-label=${`${l?"Show":"Hide"} layer ${n.number}`} title=${l?"Show":"Hide: see what is below"} @click=${()=>s.hide(n.prefix)}>${A(l?"closed":"eye")}</button><button class="ib" aria-label=${`Remove layer ${n.number}`} title="Remove this coat" @click=${()=>s.removeLayer(n)}>${A("close")}</button>`:p`<span></span><span></span>`}</div>`});return p`<div class="sec"><div class="hd"><h2>Layers</h2>${s.two?p`<span class="xs dim">edit</span><div class="seg" role="group" aria-label="Edit">${["A","B","AB"].map(n=>p`
        <button aria-pressed=${s.state.edit===n} @click=${()=>s.set({edit:n})}>${n==="AB"?"A + B":n}</button>`)}</div>`:""}
        <span class="sp"></span><button class="btn" title="A clear coat above everything" @click=${()=>s.addCoat()}>+ Coat</button></div><div class="stack" role="tablist" aria-label="Layers, top first" aria-orientation="vertical">${a}</div></div>`}var ui={water:1.333,"soap film":1.4,acrylic:1.49,"clear coat":1.5,polycarbonate:1.585,sapphire:1.77,zirconia:2.16,diamond:2.417},fi={mesh:"from the mesh",viewer:"from the viewer",flakes:"from a flake map",texture:"from a texture"},cs=(s,t)=>t.startsWith(s)&&!t.slice(s.length).includes("."),ue=s=>s.slice(s.lastIndexOf(".")+1),di=s=>s?`${s[0].toUpperCase()}${s.slice(1).replaceAll("="," = ")}.`:"";function hs(s){let t=s.edited(),e=q(t),i=e[s.layerIndex()],a=t.payload.parameters.filter(l=>cs(i.prefix,l.path)),n=t.payload.options.filter(l=>cs(i.prefix,l.path)),o=new Map(t.payload.hooks.map(l=>[l.path,l])),r=l=>l.prefix?l.prefix.slice(0,-1):l.model;return p`<div role="tabpanel" aria-label=${`Layer ${i.number}`}>
        ${t.error?p`<div class="sec"><div class="note" role="alert">${A("warn")}<div><b>${t.error.title}</b><p>${t.error.text}</p></div></div></div>`:""}
        <div class="sec"><div class="hd"><h2>${e.length>1?p`${i.number}&ensp;`:""}${i.title}</h2><span class="sp"></span><div class="pick">${mi(s,t,i)}</div><button class="ib" aria-label="Reset layer" title="Reset layer" @click=${()=>s.resetLayer(i)}>${A("reset")}</button></div>
            ${e.length>1?p`<div class="path">${e.map((l,c)=>p`${c?" › ":""}${l===i?p`<b>${r(l)}</b>`:r(l)}`)}</div>`:""}
            ${i.prefix?"":p`<p class="hint about1">${t.payload.description}</p>`}
            ${a.map(l=>vi(s,t,i,l,o.get(l.path)))}</div>
        ${n.length?p`<div class="sec"><div class="hd"><h2>Options</h2><span class="dim xs">${t.busy||"recompile in under 0.5 s"}</span><span class="sp"></span>
            ${n.some(l=>s.differs(l.path))?p`<span class="xs dim"><i class="diffdot"></i>&ensp;differs in ${t.letter==="A"?"B":"A"}</span>`:""}</div>
            ${n.map(l=>ki(s,t,l))}</div>`:""}</div>`}function mi(s,t,e){let i=s.start.catalogue.filter(o=>o.kind==="model"||!e.prefix),a=e.prefix?e.model:t.payload.name,n=(o,r)=>p`<optgroup label=${r}>${i.filter(l=>l.kind===o).map(l=>p`<option value=${l.name} ?selected=${l.name===a}>${l.name}</option>`)}</optgroup>`;return p`<select aria-label="Model of this layer" .value=${a} @change=${o=>s.chooseModel(e,o.target.value)}>
        ${i.some(o=>o.kind==="file")?n("file","Your files"):""}${n("model","Models")}${e.prefix?"":n("material","Materials")}</select>`}function pi(s,t,e){return s.used?e?fi[e.source]:s.kind==="index"&&s.width===1&&s.path.includes(".")?`over layer ${t.number-1}`:s.kind==="slope"&&s.scale==="log"?"log scale":["factor","number","length"].includes(s.kind)?"":s.kind:"unused"}function vi(s,t,e,i,a){let n=ue(i.path),o=t.values.get(i.path),r=!i.used||!!a,l=pi(i,e,a),c=t.changed(i.path)&&!r?p`<button class="rs" aria-label=${`Reset ${i.path}`} title="Reset" @click=${()=>s.resetParameter(i.path)}>${A("reset")}</button>`:p`<span></span>`,h=p`<label title=${`${i.doc}; ${ne(i)}`} @dblclick=${()=>s.resetParameter(i.path)}>${n}${l?p`<small>${l}</small>`:""}</label>`,u=(f,v="hint")=>p`<span></span><div class="wide ${v}">${f}</div><span></span>`,d=s.fieldError?.path===i.path?p`<span></span><div class="wide err" role="alert">${s.fieldError.text} The picture still shows ${o.map(f=>`${B(et(i,f))}${bt(i)}`).join(", ")}.</div><span></span>`:"",g=i.unused_because?u(di(i.unused_because)):"";if(i.width===1){let f=o[0],v=t.values.get(`${e.prefix}sigma_a`),w=n==="thickness"&&v?.some($=>$>0);return p`<div class="prm ${r?"offp":""}" title=${i.doc}>${h}${gi(s,i,f,r,w?wi(v,i):"")}${fe(s,i,f,r,0)}${c}
            ${d}${i.scale==="log"&&!w&&!r?p`<span></span><div class="tick">${ss(i).map($=>p`<span .style=${`left:${100*$.at}%`}>${$.text}</span>`)}</div><span></span><span></span>`:""}
            ${i.kind==="index"&&!r?u(bi(s,t,e,i,f),""):""}${i.kind==="angle"&&!r?u(`${B(f)} rad in code and links.`):""}
            ${w?u("Track: white light after down and up, seen from above."):""}${g}</div>`}if(i.kind==="reflectance"&&!r)return xi(s,i,o,h,c,d);let m=!r&&i.kind==="index"&&t.parameter(i.path.replace(/eta$/,"k"));return p`<div class="prm ${r?"offp":""}" title=${i.doc}>${h}${m?p`<div class="wide">${yi(s,t,i)}</div>${c}<span></span>`:""}
        <div class="tri wide">${[0,1,2].map(f=>p`<span data-c=${"RGB"[f]}>${fe(s,i,o[f],r,f)}</span>`)}</div>${m?p`<span></span>`:c}${d}${g}</div>`}function gi(s,t,e,i,a){let n=Ct(t,e),o=l=>s.setParameter(t.path,[l]),r=l=>{let c={ArrowRight:1,ArrowUp:1,ArrowLeft:-1,ArrowDown:-1}[l.key];if(!c)return;l.preventDefault();let h=Ct(t,s.edited().values.get(t.path)[0]);o(It(t,Math.min(1,Math.max(0,h+c*(l.shiftKey?.1:.01)))))};return p`<input type="range" class=${a?"beer":""} aria-label=${t.path} aria-valuetext=${`${B(et(t,e))}${bt(t)}`} min="0" max="1000" step="1" ?disabled=${i}
        .value=${String(Math.round(1e3*n))} .style=${`--f:${100*n}%;${a?`--g:${a}`:""}`} @input=${l=>o(It(t,l.target.valueAsNumber/1e3))} @keydown=${r}>`}function wi(s,t){return`linear-gradient(90deg,${Array.from({length:9},(i,a)=>G(s.map(n=>Math.exp(-2*n*It(t,a/8))))).join(",")})`}function fe(s,t,e,i,a){let n=t.width===1?`${t.path}, value`:`${t.path} ${"RGB"[a]}`,o=`${B(et(t,e))}${bt(t)}`,r=s.fieldError?.path===t.path&&s.fieldError.channel===a?s.fieldError:null,l=h=>{if(h.target.value===o)return;let u=es(t,h.target.value);if(u.error){s.fail({path:t.path,channel:a,text:u.error,typed:h.target.value});return}let d=s.edited().values.get(t.path).slice();d[a]=u.value,s.setParameter(t.path,d)},c=h=>{h.stopPropagation(),h.key==="Enter"&&l(h),h.key==="Escape"&&(h.target.value=o,s.fail(null),h.target.blur())};return p`<input class="n ${r?"bad":""}" inputmode="decimal" spellcheck="false" autocomplete="off" aria-label=${n} aria-invalid=${r?"true":"false"} ?disabled=${i}
        .value=${r?r.typed:o} title=${String(et(t,e))} @change=${l} @focus=${h=>h.target.select()} @keydown=${c}>`}var $i=(s,t)=>q(s).slice(0,t.number-1).reduce((e,i)=>e*(s.values.get(`${i.prefix}eta`)?.[0]??1),1);function bi(s,t,e,i,a){let n=i.path.includes(".")?$i(t,e):1,o=Object.entries(ui).map(([l,c])=>[l,c/n]).filter(([,l])=>l>=i.low&&(i.high===null||l<=i.high)),r=o.find(([,l])=>Math.abs(l-a)<5e-4)?.[0]??"";return p`<select aria-label=${`Named index of ${i.path}`} .value=${r} @change=${l=>l.target.value&&s.setParameter(i.path,[o.find(([c])=>c===l.target.value)[1]])}><option value="" ?selected=${!r}>custom${n!==1?`: ${B(a)} over layer ${e.number-1} (${B(a*n)} in air)`:`, ${S(a,3)}`}</option>
        ${o.map(([l,c])=>p`<option value=${l} ?selected=${l===r}>${l}, ${S(c*n,3)}${n!==1?` (${S(c,3)} here)`:""}</option>`)}</select>`}function yi(s,t,e){let i=e.path.replace(/eta$/,"k"),a=t.parameter(i),n=t.values.get(e.path),o=t.values.get(i),r=(u,d)=>d.every(g=>g>=u.low&&g<=(u.high??1/0)),l=(u,d)=>u.every((g,m)=>Math.abs(g-d[m])<1e-4),c=Object.entries(s.start.metals).filter(([,u])=>r(e,u.eta)&&r(a,u.k)),h=c.find(([,u])=>l(u.eta,n)&&l(u.k,o))?.[0]??"";return p`<select aria-label=${`Named metal of ${e.path}`} .value=${h} @change=${u=>{let d=s.start.metals[u.target.value];d&&s.setParameters({[e.path]:d.eta,[i]:d.k})}}><option value="" ?selected=${!h}>custom</option>${c.map(([u,d])=>p`<option value=${u} ?selected=${u===h}>${u}, ${d.eta.map(B).join(" ")}</option>`)}</select>`}var yt=s=>Math.min(1,Math.max(0,s));function xi(s,t,e,i,a,n){let o=s.hue?.path===t.path&&$t(ae(s.hue.hsv))===$t(e),[r,l,c]=o?s.hue.hsv:Qe(e),h=s.openColours.has(t.path),u=f=>{s.hue={path:t.path,hsv:f},s.setParameter(t.path,ae(f).map(v=>Number(yt(v).toPrecision(5))))},d=(f,v)=>{let w=f.currentTarget,$=w.getBoundingClientRect(),b=y=>v(yt((y.clientX-$.left)/$.width),yt((y.clientY-$.top)/$.height));w.setPointerCapture(f.pointerId),w.onpointermove=b,w.onpointerup=()=>{w.onpointermove=null},b(f)},g=(f,v)=>{let w={ArrowRight:[1,0],ArrowLeft:[-1,0],ArrowUp:[0,1],ArrowDown:[0,-1]}[f.key];w&&(f.preventDefault(),v(w[0]*(f.shiftKey?.1:.01),w[1]*(f.shiftKey?.1:.01)))},m=f=>{let v=Ze(f.target.value);v?s.setParameter(t.path,v):s.fail({path:t.path,channel:-1,text:`${f.target.value} is no colour such as #EFCEAD.`})};return p`<div class="prm" title=${t.doc}>${i}<div class="wide row"><button class="swt" .style=${`background:${G(e)}`} aria-expanded=${h} aria-label=${`${h?"Close":"Open"} the colours of ${t.path}`} title="Colours" @click=${()=>s.toggleColour(t.path)}></button><input class="n m left" aria-label=${`${t.path}, sRGB`} spellcheck="false" .value=${$t(e)} @change=${m} @keydown=${f=>{f.stopPropagation(),f.key==="Enter"&&m(f)}}></div>${a}
        ${h?p`<span></span><div class="wide"><div class="sv" role="slider" tabindex="0" aria-label=${`Saturation and value of ${t.path}`} aria-valuetext=${$t(e)} .style=${`--h:${r}`} @pointerdown=${f=>d(f,(v,w)=>u([r,v,1-w]))} @keydown=${f=>g(f,(v,w)=>u([r,yt(l+v),yt(c+w)]))}><i .style=${`left:${100*l}%;top:${100*(1-c)}%`}></i></div><div class="hue" role="slider" tabindex="0" aria-label=${`Hue of ${t.path}`} aria-valuenow=${Math.round(r)} @pointerdown=${f=>d(f,v=>u([360*Math.min(v,.9999),l,c]))} @keydown=${f=>g(f,v=>u([(r+300*v+360)%360,l,c]))}><i .style=${`left:${r/3.6}%`}></i></div></div><span></span>`:""}
        <label class="c"><small>linear</small></label><div class="tri wide">${[0,1,2].map(f=>p`<span data-c=${"RGB"[f]}>${fe(s,t,e[f],!1,f)}</span>`)}</div><span></span>${n}</div>`}function ki(s,t,e){let i=ue(e.path),a=t.options.get(e.path),n=t.startOf(e.path,e.default),o=e.values.filter(h=>!h.allowed),r=s.refused?.path===e.path?s.refused:null,l=h=>{let u=e.values.find(d=>d.value===h.target.value);if(u.allowed){s.setOptions({[e.path]:u.value});return}h.target.value=a,s.refuse(e.path,u)},c=Object.entries(r?.remedy??{});return p`<div class="opt" title=${e.doc}><span class=${a!==n?"ch":""}>${i}${s.differs(e.path)?p`<i class="diffdot" role="img" aria-label="differs"></i>`:""}</span><select aria-label=${e.path} data-value=${a} @change=${l}>${e.values.map(h=>p`<option value=${h.value} ?selected=${h.value===a}>${h.value}${h.allowed?"":" – refused"}</option>`)}</select>
        ${a!==n?p`<button class="rs" aria-label=${`Reset ${e.path}`} title="Reset" @click=${()=>s.setOptions({[e.path]:n})}>${A("reset")}</button>`:p`<span></span>`}
        ${r?p`<div class="why" role="alert"><p><b>${r.value}</b>: ${r.reason}</p><div class="row">
            ${c.length?p`<button class="btn" @click=${()=>s.setOptions({...r.remedy,[e.path]:r.value})}>Set ${c.map(([h,u])=>`${ue(h)} = ${u}`).join(", ")}</button>`:""}<button class="btn" @click=${()=>s.refuse(null)}>Close</button></div></div>`:""}
        ${!r&&o.length?p`<span></span><button class="hint link" @click=${()=>s.refuse(e.path,o[0])}>${o.map(h=>h.value).join(", ")} ${o.length===1?"is":"are"} refused: why?</button><span></span>`:""}</div>`}var ds=[["A","A"],["B","B"],["wipe","Wipe"],["side","Side"],["flick","Flicker"],["diff","×10"]],Mi=[["picture","Picture"],["lobe","Lobe"],["slices","Slices"],["map","θh θd"],["albedo","Albedo"],["weights","Weights"]],ms=[["plots","Plots"],["code","Code"],["about","About"]],_i=[["side","Layers","layers"],["light","Light","light"],["plots","Plots","plots"],["code","Code","code"],["about","About","info"]],de=s=>s.theme??(matchMedia("(prefers-color-scheme:light)").matches?"light":"dark");function ps(s){s.options.themed?.(de(s));let t=s.edited(),e=t.payload,i=s.phone??"side";return p`<div class="page" data-t=${de(s)} @dragover=${a=>{a.preventDefault()}} @drop=${a=>{a.preventDefault();for(let n of[...a.dataTransfer.files].slice(0,2))s.take(n)}}><div class="app" data-c=${s.two?s.state.cmp:"A"} data-d=${s.state.dock} data-p=${["plots","code","about"].includes(i)?"dock":i}>
            ${Ai(s)}${Si(s)}${Ci(s)}${Ni(s)}
            <aside class="side" aria-label="Material">${e?p`${ls(s)}${hs(s)}`:p`<div class="sec">${t.error?p`<div class="note" role="alert">${A("warn")}<div><b>${t.error.title}</b><p>${t.error.text}</p></div></div>`:p`<p class="dim">One moment …</p>`}</div>`}</aside><nav class="ptabs" role="tablist" aria-label="Panels">${_i.map(([a,n,o])=>p`<button role="tab" aria-selected=${i===a} @click=${()=>{s.phone=a,ms.some(([r])=>r===a)&&s.set({dock:a}),s.update()}}>${A(o)}${n}</button>`)}</nav></div>${s.help?s.more(a=>a.help(s)):""}${s.menu?s.more(a=>a.menu(s)):""}${s.picking?s.more(a=>a.picker(s)):""}</div>`}function vs(s,t){if(!t.payload)return"";let e=s.two?s.sides[t.letter==="A"?1:0]:null,i=[],a=e?.payload?.model===t.payload.model?e:null;for(let[n,o]of t.options)(a?.options?a.options.get(n)!==o:o!==t.startOf(n,o))&&i.push(o);for(let n of t.payload.parameters){let o=t.values.get(n.path),r=a?.values?.get(n.path);(a?r?.some((l,c)=>l!==o[c]):t.changed(n.path))&&i.push(`${n.path} ${o.length===1?Number(o[0].toPrecision(3)):""}`.trim())}return i.slice(0,3).join(", ")||(t.payload.title||"").split(":")[0]}function us(s,t){return p`<button class="chip ${t.letter}" title=${`Choose model ${t.letter}`} aria-label=${`Model ${t.letter}: ${t.text?.call&&t.payload?t.payload.name:""}. Choose another`} @click=${()=>{s.picking=t.letter,s.search="",s.update()}}><b>${t.letter}</b><span>${t.payload?.name.split("/").pop()??"…"}<small>${vs(s,t)}</small></span></button>`}function Ai(s){let t=s.state,e=()=>{s.theme=de(s)==="light"?"dark":"light",s.update()};return p`<header class="top"><div class="logo">gonio <span>view</span></div>${us(s,s.sides[0])}
        ${s.two?p`<button class="ib u" aria-label="Swap A and B" title="Swap A and B (X)" @click=${()=>s.swap()}>${A("swap")}</button>${us(s,s.sides[1])}<button class="ib u" aria-label="Stop comparing" title="Stop comparing (C)" @click=${()=>s.compare(!1)}>${A("close")}</button>`:p`<button class="btn u" title="Compare with a copy (C)" @click=${()=>s.compare(!0)}>Compare</button>`}
        <span class="sp"></span>${s.two?p`<div class="seg" role="group" aria-label="Compare">${ds.map(([i,a])=>p`<button aria-pressed=${t.cmp===i} @click=${()=>s.set({cmp:i})}>${a}</button>`)}</div><span class="sp"></span>`:""}
        <button class="ib u" aria-label="Undo" title="Undo (Ctrl Z)" ?disabled=${!s.history?.can(-1)} @click=${()=>s.step(-1)}>${A("undo")}</button><button class="ib u" aria-label="Redo" title="Redo (Ctrl Shift Z)" ?disabled=${!s.history?.can(1)} @click=${()=>s.step(1)}>${A("redo")}</button><button class="btn t" @click=${()=>s.copy(s.link(),"The link")}>Copy link</button><button class="btn t" @click=${()=>s.savePicture()}>Save picture</button><button class="ib more" aria-label="More" title="Copy link, save picture" aria-expanded=${!!s.menu} @click=${()=>{s.menu=!s.menu,s.update()}}>${A("more")}</button><button class="ib" aria-label="Light or dark" title="Light or dark" @click=${e}>${A("light")}</button></header>`}function Si(s){let t=s.state,e=s.two&&t.cmp==="wipe"&&t.view==="picture",i=s.two&&["wipe","side"].includes(t.cmp)&&t.view==="picture";return p`<main class="stage" aria-label="Picture" data-c=${s.two?t.cmp:"A"} .style=${`--w:${t.cmp==="side"?50:100*t.wipe}%`}><div class="canvas" tabindex="0" role="img" aria-label=${`${s.sides.map(a=>a.payload?.name).join(" and ")} under ${t.furnace?"the furnace":t.env}. Arrows turn the camera.`} @pointerdown=${a=>Ti(s,a)} @pointermove=${a=>zi(s,a)} @pointerleave=${()=>{s.pointer=null}} @wheel=${a=>{a.preventDefault(),s.set({dist:Math.min(40,Math.max(2.5,t.dist*Math.exp(a.deltaY*.001)))},"dist")}} @keydown=${a=>Ei(s,a)} @dblclick=${a=>{let n=me(s,a);n&&s.probe(...n)}}></div>
        ${t.view!=="picture"?s.more(a=>a.large(s),p`<div class="large"></div>`):""}
        ${e?p`<div class="wipe" role="slider" tabindex="0" aria-orientation="horizontal" aria-label="Wipe between A and B" aria-valuemin="0" aria-valuemax="100" aria-valuenow=${Math.round(100*t.wipe)} @pointerdown=${a=>Oi(s,a)} @keydown=${a=>{let n={ArrowLeft:-1,ArrowRight:1}[a.key];n&&(a.preventDefault(),a.stopPropagation(),s.set({wipe:Math.min(1,Math.max(0,t.wipe+n*(a.shiftKey?.1:.01)))},"wipe"))}}><i>${A("wipe")}</i></div>`:""}
        ${i?s.sides.map(a=>p`<div class="glass tag ${a.letter}"><b class="k ${a.letter==="B"?"kb":""}">${a.letter}</b><span>${vs(s,a)}</span></div>`):""}
        <div class="glass views" role="tablist" aria-label="View">${Mi.map(([a,n])=>p`<button role="tab" aria-selected=${t.view===a} @click=${()=>s.set({view:a})}>${n}</button>`)}</div>
        ${Ui(s)}${t.view==="picture"?Bi(s):""}${Pi(s)}
        ${s.notes.length?p`<div class="notes" aria-live="polite">${s.notes.map(a=>p`<div class="glass note1 ${a.kind}">${A(a.kind==="warn"?"warn":"info")}<div><b>${a.title}</b>${a.text?p`<p>${a.text}</p>`:""}</div><button class="ib" aria-label="Close message" @click=${()=>s.dismiss(a)}>${A("close")}</button></div>`)}</div>`:""}
        <div class="glass keys">${s.two?p`<span><kbd>W</kbd>wipe</span>`:p`<span><kbd>C</kbd>compare</span>`}<span><kbd>F</kbd>furnace</span><button @click=${()=>{s.help=!0,s.update()}}><kbd>?</kbd>all keys</button></div></main>`}function Ui(s){let t=s.renderer?.settings?s.renderer.visible():[],e=Math.min(...t.map(n=>n.shown||0),1/0),i=s.statistics?.sides,a=i?.length?Math.max(...i.map(n=>n.noise)):null;return p`<div class="glass qual" title="Samples per pixel, noise of the mean, time per pass"><i class="h" .style=${`--q:${Number.isFinite(e)?100*e/s.renderer.limit:0}%`}></i><span><b>${Number.isFinite(e)?e:0}</b> <span class="dim">spp</span></span>
        ${a===null?"":p`<span><b>${a<.1?S(100*a,1):Math.round(100*a)} %</b> <span class="dim">noise</span></span>`}${s.renderer?p`<span class="h"><b>${s.renderer.ms<100?S(s.renderer.ms,1):Math.round(s.renderer.ms)}</b> <span class="dim">ms</span></span>`:""}<span class="dim h" title=${s.gpu?.adapter??""}>${s.gpu?.name??"no GPU"}</span></div>`}function Pi(s){let t=s.statistics;return!t||s.state.view!=="picture"?"":p`<div class="glass cmp" title="Linear values, whole picture, no tone curve">${t.rmse===null?"":p`<span><span class="dim">RMSE</span><b>${S(t.rmse)}</b></span>`}${t.sides.map(e=>p`<span class=${s.two?"h":""}><span class="dim">mean ${s.two?e.letter:""}</span><b class="thin">${S(e.mean)}</b></span>`)}</div>`}function me(s,t){let e=t.currentTarget.getBoundingClientRect(),i=(t.clientX-e.left)/e.width,a=(t.clientY-e.top)/e.height;return s.two&&s.state.cmp==="side"&&(i=i*2%1),i>=0&&i<=1&&a>=0&&a<=1?[i,a]:null}function zi(s,t){s.pointer=me(s,t)}function Ti(s,t){let e=t.currentTarget,{az:i,el:a}=s.state,[n,o]=[t.clientX,t.clientY],r=me(s,t),l=!1;e.setPointerCapture(t.pointerId);let c=u=>{if(!l&&Math.hypot(u.clientX-n,u.clientY-o)<4)return;l=!0;let d=(i-(u.clientX-n)*.4+540)%360-180;s.set({az:Math.round(d*10)/10,el:Math.round(Math.min(85,Math.max(s.state.furnace?-85:-2,a+(u.clientY-o)*.3))*10)/10},"camera")},h=()=>{e.removeEventListener("pointermove",c),e.removeEventListener("pointerup",h),!l&&r&&matchMedia("(pointer:coarse)").matches&&s.probe(...r)};e.addEventListener("pointermove",c),e.addEventListener("pointerup",h)}function Ei(s,t){let e={ArrowLeft:[-5,0],ArrowRight:[5,0],ArrowUp:[0,3],ArrowDown:[0,-3]}[t.key];e&&(t.preventDefault(),s.set({az:(s.state.az+e[0]+540)%360-180,el:Math.min(85,Math.max(-2,s.state.el+e[1]))},"camera"))}function Oi(s,t){let e=t.currentTarget,i=e.parentNode.getBoundingClientRect();t.preventDefault(),e.setPointerCapture(t.pointerId);let a=n=>s.set({wipe:Math.round(Math.min(1,Math.max(0,(n.clientX-i.left)/i.width))*1e3)/1e3},"wipe");e.onpointermove=a,e.onpointerup=()=>{e.onpointermove=null}}var fs=s=>`${S(Math.acos(Math.max(-1,Math.min(1,s)))*180/Math.PI,1)}°`;function Bi(s){let t=s.probed;if(!s.state.probe||!t)return"";let e=s.two&&s.state.cmp==="side"?t.x/2:t.x;return p`<span class="hair" aria-hidden="true" .style=${`left:${100*e}%;top:${100*t.y}%`}></span>${gs(s,`glass probe ${e>.6?"west":""}`)}`}function gs(s,t){let e=s.probed;if(!s.state.probe||!e)return"";let[i,a]=s.renderer.pictureSize(s.state),n=p`<button class="xs dim" title="Close (P or Esc)" @click=${()=>s.set({probe:""})}><kbd>P</kbd>close</button>`,o=p`<h3>Probe <span class="dim">pixel ${Math.floor(e.x*i)}, ${Math.floor(e.y*a)}</span><span class="sp"></span>${n}</h3>`;if(!e.found)return p`<section class=${t} aria-label="Probe">${o}<p class="dim">Not on the material.</p></section>`;let{wi:r,wo:l}=e.found,c=Math.atan2(r[1],r[0])-Math.atan2(l[1],l[0]),h=Math.abs((c*180/Math.PI+540)%360-180),u=d=>d.letter==="B"?"isB":"";return p`<section class=${t} aria-label="Probe">${o}
        <table class="dirs"><tbody>${[["ωi",r],["ωo",l]].map(([d,g])=>p`<tr><td>${d}</td>${g.map(m=>p`<td>${S(m,3)}</td>`)}</tr>`)}<tr><td>angles</td><td colspan="3">θi ${fs(r[2])}&ensp;θo ${fs(l[2])}&ensp;φ ${S(h,1)}°</td></tr></tbody></table><hr><table><tbody><tr><th scope="col"><span class="sr">Quantity</span></th><th scope="col">R</th><th scope="col">G</th><th scope="col">B</th></tr>
            ${e.values.map(d=>p`<tr class=${u(d)} data-probe=${`f${d.letter}`}><td>f${s.two?p`&ensp;${d.letter}`:""}</td>${d.f.map(g=>p`<td data-value=${g}>${S(g)}</td>`)}</tr>`)}
            ${e.values.map(d=>p`<tr class=${u(d)} data-probe=${`albedo${d.letter}`}><td>albedo ${s.two?d.letter:""}</td>${d.albedo.map(g=>p`<td data-value=${g}>${S(g)}</td>`)}</tr>`)}
            ${e.values.length?p`<tr data-probe="pdf"><td>pdf</td><td colspan="3">${e.values.map(d=>S(d.pdf)).filter((d,g,m)=>m.indexOf(d)===g).join(", ")} /sr${e.values.length===2&&S(e.values[0].pdf)===S(e.values[1].pdf)?", both":""}</td></tr>`:""}</tbody></table></section>`}var ws=s=>p`<label class="thetao">θo <b>${Math.round(s.state.theta)}°</b><input type="range" min="0" max="89" step="1" aria-label="Angle of the viewer" .value=${String(s.state.theta)} .style=${`--f:${100*s.state.theta/89}%`} @input=${t=>s.set({theta:t.target.valueAsNumber},"theta")}></label>`,$s=s=>p`<select class="channel" aria-label="Channel" .value=${String(s.channel)} @change=${t=>{s.channel=Number(t.target.value),s.update()}}>${oe.map((t,e)=>p`<option value=${e} ?selected=${e===s.channel}>${t}</option>`)}</select>`,bs=s=>s.plots().map(t=>p`<span class="map"><canvas data-map=${t.letter} role="img" aria-label=${`f of ${t.letter} over half and difference angle`}></canvas>${s.two?p`<b class="k ${t.letter==="B"?"kb":""}">${t.letter}</b>`:""}<small class="y">90°</small><small class="y0">θd</small><small class="x0">0°</small><small class="xm">θh</small><small class="x1">90°</small></span>`);function Ci(s){let t=s.state,e=s.start.environments,i=()=>Ii(s);return p`<section class="light" aria-label="Light"><button class="sw" role="switch" aria-checked=${t.furnace} title="Radiance 1 from everywhere (F)" @click=${()=>s.set({furnace:!t.furnace})}><i></i>Furnace</button><div class="envs w">${Object.keys(e).map(a=>p`<button class=${`env-${a}`} aria-pressed=${t.env===a} title=${a} @click=${()=>s.set({env:a})}><canvas data-env=${a} aria-hidden="true"></canvas><span>${a}</span></button>`)}${s.renderer?.sky?p`<button aria-pressed=${t.env==="own"} @click=${()=>s.set({env:"own"})}><span>own</span></button>`:""}<button class="drop h" aria-label="Open an HDR picture or a mesh" title="Drop .hdr, .exr, .obj or .glb anywhere, or choose a file" @click=${i}>Drop<br>HDR, OBJ</button></div><div class="g"><label>Turn light<b>${Math.round(t.turn)}°</b></label><input type="range" class="bi" aria-label="Turn light" min="-180" max="180" .value=${String(t.turn)} @input=${a=>s.set({turn:a.target.valueAsNumber},"turn")} @dblclick=${()=>s.set({turn:0})}></div><div class="g"><label>Exposure<b>${t.ev<0?"−":"+"}${Math.abs(t.ev).toFixed(1)} EV</b></label><input type="range" class="bi" aria-label="Exposure" min="-6" max="6" step=".1" .value=${String(t.ev)} @input=${a=>s.set({ev:a.target.valueAsNumber},"ev")} @dblclick=${()=>s.set({ev:0})}></div><div class="g tone"><select aria-label="Tone curve" .value=${t.tone} @change=${a=>s.set({tone:a.target.value})}>${["none","reinhard","filmic"].map(a=>p`<option value=${a} ?selected=${a===t.tone}>Tone: ${a}</option>`)}</select></div><div class="g shape"><select aria-label="Shape" .value=${t.shape} @change=${a=>a.target.value==="open"?i():s.set({shape:a.target.value})}>${[["ball","Ball"],["sphere","Sphere"],...s.renderer?.own?[["own","Own mesh"]]:[],["open","Open mesh …"]].map(([a,n])=>p`<option value=${a} ?selected=${a===t.shape}>${n}</option>`)}</select></div><div class="phone w" role="group" aria-label="Compare and share">${s.two?p`<div class="seg">${ds.map(([a,n])=>p`<button aria-pressed=${t.cmp===a} @click=${()=>s.set({cmp:a})}>${n}</button>`)}</div>`:""}
            <div class="row"><button class="btn" @click=${()=>s.compare()}>${s.two?"Stop comparing":"Compare"}</button><button class="btn" @click=${()=>s.copy(s.link(),"The link")}>Copy link</button><button class="btn" @click=${()=>s.savePicture()}>Save picture</button></div></div></section>`}function Ii(s){let t=document.createElement("input");t.type="file",t.accept=".hdr,.exr,.obj,.glb",t.onchange=()=>t.files[0]&&s.take(t.files[0]),t.click()}function Ni(s){let t=s.state,e=s.plots(),i=(n,o,r)=>p`<figcaption>${n}<span>${o}</span><button class="ib" aria-label=${`Show ${n} large`} title="Show large" @click=${()=>s.set({view:r})}>${A("large")}</button></figcaption>`,a=()=>p`<div class="plots"><figure>${i("Lobe slice","f cos θi, log radius, 1/sr","slices")}${e.length?Rt(s,"polar","Slice of the lobe, logarithmic radius",(n,o)=>re(e,s.channel,n,o)):""}</figure><figure>${i("Albedo",`over θo, ${oe[s.channel]}`,"albedo")}${e.length?Rt(s,"albedo","Directional albedo",(n,o)=>ce(e,s.channel,n,o,t.theta)):""}</figure><figure>${i("Half and difference angle","f","map")}<div class="maps">${bs(s)}</div></figure>${gs(s,"probe docked")}</div>`;return p`<section class="dock"><div class="tabs" role="tablist" aria-label="Dock">${ms.map(([n,o])=>p`<button role="tab" aria-selected=${t.dock===n} @click=${()=>s.set({dock:n})}>${o}</button>`)}<span class="sp"></span>${t.dock==="plots"?p`${ws(s)}${$s(s)}${s.two?p`<span class="xs dim row lg"><i class="la"></i>A<i class="lb"></i>B</span>`:""}`:""}</div><div class="pane ${t.dock==="plots"?"":t.dock}">${t.dock==="plots"?a():s.more(n=>t.dock==="code"?n.codePane(s):n.aboutPane(s))}</div></section>`}var ys={albedo:ce,axes:le,channels:$s,chart:Rt,direction:Q,html:p,layersOf:q,line:Lt,mapCanvases:bs,packRows:ht,path:X,pick:st,polar:re,svg:_,theta:ws};var Li="The picture and its sliders go on. New models, choices and code need it: start it again, and paste this page's link behind its address.",Ft=class{constructor(t,e,i={}){Object.assign(this,{root:t,source:e,options:i,sizes:{},data:{},lobes:{},statistics:null,notes:[],code:{},language:"wgsl"}),this.state={...tt},this.sides=[new gt("A")],this.openColours=new Set,this.channel=3,this.lobe={az:-62,el:22,log:!0,weights:!0},this.wanted=i.graphics??"",this.coming={},this.looks=0}more(t,e=""){return this.loaded?t(this.loaded):(this.#t().then(i=>{this.loaded=i,this.update()},i=>this.say("This view cannot be loaded.",i.message,"warn")),e)}async#t(){let t=await this.part("more");return t.share(ys),t}part(t){return this.coming[t]??=this.source.part(t)}async open(){let{state:t,bad:e}=Bt(this.options.fragment??""),[i,{gpu:a,reason:n}]=await Promise.all([this.source.start(),Tt(this.source,this.wanted).catch(o=>({gpu:null,reason:o.message}))]);return this.start=i,Object.assign(this.state,Je(t,this.start.environments,e)),this.state.a||(this.state.a=this.start.show[0]??"eon"),!this.state.b&&!("a"in t)&&this.start.show[1]&&(this.state.b=this.start.show[1]),this.state.b?"cmp"in t||(this.state.cmp="wipe"):this.state.cmp="A",e.length&&this.say("This link was taken in part.",`Not understood: ${[...new Set(e)].filter(Boolean).join(", ")||"a part without a name"}.`),a?this.#s(a):this.say("No picture can be drawn here.",n,"warn"),a?.name==="WebGL2"&&!this.wanted&&this.say("WebGL2 is used instead of WebGPU.",`${n} All views work; shaders compile more slowly.`),this.update(),setTimeout(()=>this.renderer?.prepare({...this.state})),await this.#a(),this.history=new Et(this.#v()),this.openColours.add(this.edited().payload?.parameters.find(o=>o.kind==="reflectance")?.path),this.#p(),this.source.watch(o=>this.#g(o)),this.update(),this}#s(t){this.renderer?this.renderer.replace(t):(this.renderer=new zt(t,this.start,e=>this.#$(e)),this.renderer.sides=this.sides,this.renderer.failed=e=>{this.failedOn!==this.gpu&&(this.failedOn=this.gpu,this.failures=(this.failures??0)+1,this.say("The picture stopped.",e.message,"warn"),this.failures<4&&this.#e(this.gpu))},this.renderer.run()),this.gpu=t,t.lost.then(e=>{(t===this.gpu&&!this.closed&&e.reason!=="destroyed"||this.testLoss)&&this.#e(t)})}async#e(t){if(this.closed||t!==this.gpu)return;this.testLoss=!1,this.gpu=null;let e=await Tt(this.source,this.wanted).catch(i=>({reason:i.message}));if(!e.gpu){this.say("The GPU was lost.",`${e.reason} The last picture stays.`,"warn");return}this.#s(e.gpu),this.update(),await Promise.all(this.sides.map(i=>this.#o(i))),this.say("The GPU was lost and is back.","Everything was restored from the page's state; the picture starts again."),this.moved(!1)}get two(){return this.sides.length>1}async#a(){!!this.state.b!==this.two&&(this.sides.length=1,this.state.b&&this.sides.push(new gt("B")),this.two||Object.assign(this.state,{cmp:"A",edit:"A"})),await Promise.all(this.sides.map(t=>this.#i(t,this.state[t.letter.toLowerCase()])))}async#i(t,e){let i=t.turn=(t.turn??0)+1,a=setTimeout(()=>{t.busy="compiling …",this.update()},200);try{let n=await this.#n(e);if(t.turn!==i)return!1;await this.#f(t,n);let o=t.payload,r=o&&{program:t.program,values:t.values,options:t.options,models:t.models},l=o&&t.program&&["code","hooks"].every(c=>Ri(o[c],n[c]))&&o.tables?.rows===n.tables?.rows;if(t.take(n),!l){try{await this.#o(t,i)}catch(c){throw o&&Object.assign(t,{payload:o,...r}),new Error(`This GPU's driver refuses the shader: ${c.message}`)}if(t.turn!==i)return!1}return t.error="",this.state[t.letter.toLowerCase()]=t.text(),this.#m(t),this.moved(),!0}catch(n){if(t.turn!==i)return!1;if(t.error={title:e.length>80?`${e.slice(0,77)}…`:e,text:`${n.message} ${t.payload?"The picture is of the last model that worked.":""}`},!t.payload){let o=this.start.show.find(l=>l!==e)??"eon",{error:r}=t;e!==o&&await this.#i(t,o)&&(t.error=r,this.say(`${r.title} cannot be shown.`,`${n.message} ${o} is shown instead.`,"warn"))}return!1}finally{clearTimeout(a),t.turn===i&&(t.busy=""),this.update()}}async#n(t){let{[t]:e}=this.start.models;return!this.source.live||!e?this.source.model(t):(delete this.start.models[t],e)}async#f(t,e){let i=(h,u)=>!h||u in h.code;if(!this.gpu||i(e,this.gpu.language))return;let a=this.sides.find(h=>h!==t),n=this.gpu.language==="wgsl"?"webgl2":"webgpu",o=Object.keys(e.code)[0];if(!i(a?.payload,o))throw new Error(`${e.foreign.language} and ${a.payload.foreign.language} run in different interfaces of the browser and cannot be shown side by side; compare each with a model of gonio's.`);let{gpu:r,reason:l}=await Tt(this.source,n);if(r.language!==o)throw r.close(),new Error(`${e.foreign.language} needs WebGPU. ${l}`);this.wanted=n;let c=this.gpu;this.#s(r),c.close(),a?.payload&&await this.#o(a),this.say(`${r.name} is used now.`,`${e.name} is ${e.foreign.language} and runs there as it stands.`,"info",6e3)}async#o(t,e=t.turn){if(!this.gpu)return;let{gpu:i}=this,a=await this.#u(t),n=await i.compile(a.payload);if(t.turn!==e||i!==this.gpu)return;t.active=a;let o=t.program;t.program=n,t.samples=0,t.epoch=-1,o?.model&&t.film&&setTimeout(()=>i.forget(o),2e3)}async#u(t){if(!t.hidden.size)return{payload:t.payload,path:n=>n};let{text:e,path:i}=(await this.#t()).visible(t);return{payload:{...await this.source.model(e),hooks:[]},path:i}}async#m(t){let{payload:e}=t;if(!(!this.source.live||!e.options.length))try{let{options:i,unused:a}=await this.source.options(t.text());if(t.payload===e){e.options=i.map(n=>({...n,value:t.options.get(n.path)}));for(let n of e.parameters)n.unused_because??=a[n.path];this.update()}}catch{}}async#g({file:t,ended:e}){if(e!==void 0){this.ended&&this.dismiss(this.ended),this.ended=e&&this.say("gonio view has stopped.",Li,"warn");return}for(let i of this.sides)i.payload?.name===t&&await this.#i(i,i.text())&&this.say(`${t} was read again.`,"","info",3e3)}edited(){return this.state.edit==="B"&&this.two?this.sides[1]:this.sides[0]}#r(){return this.state.edit==="AB"&&this.two?this.sides:[this.edited()]}layerIndex(){return Math.min(this.state.layer,q(this.edited()).length-1)}differs(t){if(!this.two||!this.sides[1].payload||!this.sides[0].payload)return!1;let[e,i]=this.sides.map(a=>a.options.get(t));return e!==void 0&&i!==void 0&&e!==i}set(t,e=""){Object.assign(this.state,t),["furnace","env","turn","shape","az","el","dist"].some(a=>a in t)?this.moved():this.renderer?.refresh(this.state),"cmp"in t&&(this.moved(!1),this.#p()),("theta"in t||"view"in t||"dock"in t)&&this.#h(),"dock"in t&&this.#d(),this.#c(e||Object.keys(t).join()),this.update()}#p(){clearInterval(this.flickering),!(this.state.cmp!=="flick"||!this.renderer)&&(this.flickering=setInterval(()=>{this.renderer.flicker=!this.renderer.flicker,this.renderer.show()},500))}setParameter(t,e){this.setParameters({[t]:e})}setParameters(t,e=Object.keys(t).join()){this.fieldError=null;for(let i of this.#r()){for(let[a,n]of Object.entries(t))i.values.has(a)&&i.values.set(a,n.slice());this.state[i.letter.toLowerCase()]=i.text()}this.moved(),this.#c(e),this.options.changed?.(this),this.update()}resetParameter(t){let e=this.edited().parameter(t);this.setParameters({[t]:this.edited().startOf(t,e.default)},"")}async setOptions(t){this.refused=null;for(let e of this.#r()){let i=Object.fromEntries(Object.entries(t).filter(([a])=>e.options.has(a)||e.models.has(a)));!Object.keys(i).length||await this.#l(e,e.text(i))||await this.#w(e,i)}}async#w(t,e){await this.#m(t);for(let[i,a]of Object.entries(e)){let n=t.payload?.options.find(o=>o.path===i)?.values.find(o=>o.value===a&&!o.allowed);if(n){t.error="",this.refuse(i,n);return}}}async#l(t,e){let i=await this.#i(t,e);return i&&(this.#c(),this.options.changed?.(this)),this.update(),i}chooseModel(t,e){for(let i of this.#r())i.hidden.clear(),t.prefix?this.#l(i,i.text({[t.prefix.slice(0,-1)]:e})):this.#l(i,e)}resetLayer({prefix:t}){let e=this.edited(),i=o=>o.startsWith(t)&&!o.slice(t.length).includes("."),a={},n={};for(let o of e.payload.parameters)i(o.path)&&(a[o.path]=e.startOf(o.path,o.default));for(let o of e.payload.options){let r=e.startOf(o.path,o.default);i(o.path)&&e.options.get(o.path)!==r&&(n[o.path]=r)}this.setParameters(a,""),Object.keys(n).length&&this.setOptions(n)}async addCoat(){let{coated:t}=await this.#t();for(let e of this.#r()){let i=t(e,this.start.catalogue);if(!i){this.say("A coat cannot go over this.",`${e.payload.name} is a file or a material with textures; coats go over gonio's models.`,"warn");continue}e.hidden.clear(),this.#l(e,i).then(()=>this.set({layer:0}))}}async removeLayer(t){let{without:e}=await this.#t();for(let i of this.#r()){let a=e(i,t);a&&(i.hidden.clear(),this.#l(i,a))}}async hide(t){for(let e of this.#r()){e.hidden.delete(t)||e.hidden.add(t);try{await this.#o(e)}catch(i){this.say("This layer cannot be hidden.",i.message,"warn"),e.hidden.clear()}}this.moved(!1),this.update()}async compare(t=!this.two,e=""){t&&!this.two?(this.state.b=e||this.sides[0].text(),this.state.cmp="wipe",this.state.edit="B"):t||Object.assign(this.state,{b:"",cmp:"A",edit:"A"}),await this.#a(),this.#c(),this.moved(!1),this.options.changed?.(this),this.update()}swap(){this.two&&(this.sides.reverse(),this.sides.forEach((t,e)=>{t.letter="AB"[e],this.state["ab"[e]]=t.text()}),this.renderer?.refresh(this.state),this.#h(),this.#c(),this.update())}toggleColour(t){this.openColours.delete(t)||this.openColours.add(t),this.update()}refuse(t,e){this.refused=t&&{path:t,...e},this.update()}fail(t){this.fieldError=t,this.update()}say(t,e="",i="info",a=0){let n={title:t,text:e,kind:i};return this.notes=[...this.notes.slice(-2),n],a&&setTimeout(()=>this.dismiss(n),a),this.update(),n}dismiss(t){this.notes=this.notes.filter(e=>e!==t),this.update()}moved(t=!0){this.looks++,this.renderer?.restart({...this.state},{moving:t}),this.statistics=null,this.#h(),this.#d()}#v(){return{...this.state}}#c(t){this.history?.add(this.#v(),t),this.options.linked?.(Ot(this.state))}async step(t){let e=this.history.step(t);if(e){Object.assign(this.state,e);for(let i of this.sides)i.hidden.clear();await this.#a(),this.moved(!1),this.options.linked?.(Ot(this.state)),this.options.changed?.(this),this.update()}}link(){return`${this.options.address??location.href.split("#")[0]}#${Ot(this.state)}`}show(t,e="a"){let i=this.sides[e==="a"?0:1];return i&&i.text()!==t?this.#l(i,t):null}async follow(t){return!t==!this.two?t?this.show(t,"b"):null:this.compare(!!t,t)}async copy(t,e){try{await navigator.clipboard.writeText(t),this.say(`${e} is copied.`,"","info",2500)}catch{this.say(`${e} could not be copied; here it is.`,t)}}async savePicture(){return(await this.part("more")).savePicture(this)}async take(t){try{let{openFile:e}=await this.part("files"),i=await e(t);i.picture?(this.renderer.sky=i.picture,this.set({env:"own",furnace:!1}),this.moved(!1)):(this.renderer.own=i,this.renderer.scenes.clear(),this.set({shape:"own"}),this.moved(!1)),this.say(`${t.name} is shown.`,i.note??"","info",4e3)}catch(e){let i=/\.(obj|glb|gltf)$/i.test(t.name)?`The shape is still “${this.state.shape}”.`:`The light is still “${this.state.env}”.`;this.say(`${t.name} was not taken.`,`${e.message} ${i}`,"warn")}}#$(t){let e=t.samples;e>=4&&(e&e-1)===0&&t.scale===1&&this.#y(),this.#b()}#b(){this.progress??=setTimeout(()=>{this.progress=null,this.update()},150)}async#y(){let{epoch:t}=this.renderer;try{let e=await this.renderer.statistics();e&&this.renderer.epoch===t&&(this.statistics=e,this.update())}catch{}}#h(){clearTimeout(this.measuring),this.measuring=setTimeout(()=>this.#x(),60)}async#x(){if(!this.gpu||this.busyMeasuring||!(this.renderer.begun||this.renderer.paused)){this.gpu&&this.#h();return}this.busyMeasuring=!0;try{for(let t of this.sides){if(!t.program)continue;let{letter:e}=t,i=`${t.active.payload.text}|${JSON.stringify([...t.values])}|${this.state.theta}`,a=["lobe","weights"].includes(this.state.view);this.data[e]?.key!==i&&(this.data[e]={...await Se(this.gpu,t,this.state.theta),letter:e,key:i});let{lobe:n}=a?await this.#t():{};a&&this.lobes[e]?.key!==i&&(this.lobes[e]={...await n(this.gpu,t,this.state.theta),letter:e,key:i})}await this.#k()}catch(t){this.gpu&&(this.plotError=t.message)}this.busyMeasuring=!1,this.update()}plots(){return this.sides.map(t=>this.data[t.letter]).filter(Boolean)}bodies(){return this.sides.map(t=>this.lobes[t.letter]).filter(Boolean)}probe(t,e){this.looks++,this.probed=null;let i={probe:`${t.toFixed(4)},${e.toFixed(4)}`},a=this.surface(t,e);a&&(i.theta=Math.min(89,Math.round(Math.acos(Math.min(1,a.wo[2]))*180/Math.PI))),this.set(i,"probe"),this.#h()}async#k(){let[t,e]=this.state.probe.split(",").map(Number);if(!this.state.probe||!Number.isFinite(t)||!Number.isFinite(e)){this.probed=null;return}let{looks:i}=this,a=this.surface(t,e),n={x:t,y:e,found:a,values:[]};for(let o of a?this.sides.filter(r=>r.program):[]){let{wi:r,wo:l,growth:c,uv:h,t:u}=a,d=c===void 0||!o.payload.hooks.length,g=o.packed(d?{}:o.overrides(h,c,u,o.mapData??o.maps())),m=await this.gpu.rows(o.program,g,ht([[r,l]])),f=d&&!o.hidden.size&&o.payload.sums&&this.source.live,v=f?await this.source.albedo(o.text(),l):await this.gpu.albedo(o.program,g,new Float32Array([...l,0])),{letter:w}=o;n.values.push({letter:w,f:[...m.slice(0,3)],pdf:m[3],albedo:[...v.slice(0,3)]})}i===this.looks&&(this.probed=n)}surface(t,e){return Ve(this.renderer,this.state,t,e)}#d(){this.state.dock==="code"&&(clearTimeout(this.coding),this.coding=setTimeout(()=>this.#M(),120))}async#M(){let t=this.edited();if(!t.payload)return;let e=t.text();try{this.code={text:await this.source.code(e,this.language),of:e}}catch(i){this.code={error:i.message}}this.update()}setLanguage(t){this.language=t,this.code={},this.#d(),this.update()}update(){this.drawing||this.closed||(this.drawing=!0,requestAnimationFrame(()=>{this.drawing=!1,this.closed||this.draw()}))}draw(){if(!this.start)return;Ae(ps(this),this.root);for(let o of this.root.querySelectorAll("[data-value]"))o.value=o.dataset.value;let t=this.root.querySelector(".canvas");this.gpu&&t&&this.gpu.canvas.parentNode!==t&&(t.replaceChildren(this.gpu.canvas),this.#_(t));let e=!1;for(let o of this.root.querySelectorAll("[data-chart]")){let r=o.clientWidth||o.getBoundingClientRect().width,l=o.clientHeight||o.getBoundingClientRect().height,c=this.sizes[o.dataset.chart];r&&(c?.width!==r||c?.height!==l)&&(this.sizes[o.dataset.chart]={width:r,height:l},e=!0)}let i=Math.min(devicePixelRatio,2);for(let o of this.root.querySelectorAll("canvas[data-map]")){let r=this.data[o.dataset.map];r&&o.drawn!==r.key&&(as(o,r.map),o.drawn=r.key)}let a=this.root.querySelector("canvas.lobe"),n=this.root.querySelector("canvas.weights");a&&this.bodies().length&&this.loaded.drawLobe(a,this.bodies(),this.lobe,i),n&&this.bodies().length&&this.loaded.drawWeights(n,this.bodies(),i),this.renderer?.begun&&this.more(o=>{for(let r of this.root.querySelectorAll("canvas[data-env]:not(.drawn)"))o.drawThumb(r,this.start.environments[r.dataset.env]),r.className="drawn"}),e&&this.update()}#_(t){this.observer?.disconnect(),this.observer=new ResizeObserver(([e])=>{let i=e.devicePixelContentBoxSize?.[0],a=Math.min(devicePixelRatio,2)/devicePixelRatio,n=Math.max(16,Math.round((i?i.inlineSize:e.contentRect.width*devicePixelRatio)*a)),o=Math.max(16,Math.round((i?i.blockSize:e.contentRect.height*devicePixelRatio)*a)),{canvas:r}=this.gpu??{};!r||r.width===n&&r.height===o||(r.width=n,r.height=o,this.renderer.size=[n,o],this.renderer.show(),this.moved(!1))});try{this.observer.observe(t,{box:"device-pixel-content-box"})}catch{this.observer.observe(t)}this.unlisten??=ns(this)}close(){this.closed=!0,this.observer?.disconnect(),this.unlisten?.(),clearTimeout(this.measuring),clearInterval(this.flickering),this.renderer?.close()}},Ri=(s,t)=>JSON.stringify(s)===JSON.stringify(t);async function xs(s,t,e={}){let i=s.attachShadow({mode:"open"}),a=new CSSStyleSheet;return a.replaceSync(await t.file("viewer.css")),i.adoptedStyleSheets=[a],new Ft(i,t,e).open()}async function Fi(){let s=document.getElementById("gonio-data"),t=document.createElement("div");document.body.append(t),document.documentElement.style.height=document.body.style.height="100%",document.body.style.margin="0";let e=location.hash,i=/(?:^#|&)token=([\w-]+)/.exec(e)?.[1],a,n=r=>history.replaceState(null,"",`#${r}`);if(s){let r=Uint8Array.from(atob(s.textContent.trim()),c=>c.charCodeAt(0)),l=await new Response(new Blob([r]).stream().pipeThrough(new DecompressionStream("gzip"))).text();a=new Mt(JSON.parse(l))}else i&&sessionStorage.setItem("gonio-token",i),a=new kt(i??sessionStorage.getItem("gonio-token")??"");let o=new URLSearchParams(location.search).get("graphics")??"";try{let r=e.replace(/(^#|&)token=[\w-]+&?/,"$1");globalThis.gonio=await xs(t,a,{fragment:r,linked:n,graphics:o,themed:c=>{document.documentElement.style.colorScheme=c}}),document.title=`${globalThis.gonio.sides.map(c=>c.text()).join(" | ").slice(0,120)} – gonio view`,addEventListener("hashchange",()=>{let{state:c}=Bt(location.hash);c.a&&location.reload()})}catch(r){t.textContent=r.message,t.style.cssText="font:15px sans-serif;padding:48px;max-width:60ch"}}async function Di({model:s,el:t}){let e=document.createElement("div");e.className="embedded",e.style.height=`${s.get("height")}px`,t.append(e);let i=()=>["a","b"].filter(r=>s.get(r)).map(r=>`${r}=${encodeURIComponent(s.get(r))}`).join("&"),a=r=>{for(let[l,c]of["a","b"].entries())s.set(c,r.sides[l]?.payload?r.sides[l].text():"");s.save_changes()},n=await xs(e,new _t(s),{fragment:`${i()}&${s.get("settings")}`,keys:e,changed:a,linked:r=>{s.set("link",r),s.save_changes()}}),o={"change:a":()=>n.show(s.get("a"),"a"),"change:b":()=>n.follow(s.get("b"))};for(let[r,l]of Object.entries(o))s.on(r,l);return()=>{for(let[r,l]of Object.entries(o))s.off(r,l);n.close()}}var dn={render:Di};(document.getElementById("gonio-data")||document.querySelector('script[src="/viewer.js"]'))&&Fi();export{dn as default,xs as mount};
