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
var Zt=globalThis,be=e=>e,kt=Zt.trustedTypes,ye=kt?kt.createPolicy("lit-html",{createHTML:e=>e}):void 0,Se="$lit$",j=`lit$${Math.random().toFixed(9).slice(2)}$`,Pe="?"+j,Ts=`<${Pe}>`,X=document,nt=()=>X.createComment(""),ot=e=>e===null||typeof e!="object"&&typeof e!="function",Qt=Array.isArray,Es=e=>Qt(e)||typeof e?.[Symbol.iterator]=="function",Wt=`[ 	
\f\r]`,at=/<(?:(!--|\/[^a-zA-Z])|(\/?[a-zA-Z][^>\s]*)|(\/?$))/g,xe=/-->/g,ke=/>/g,V=RegExp(`>|${Wt}(?:([^\\s"'>=/]+)(${Wt}*=${Wt}*(?:[^ 	
\f\r"'\`<>=]|("|')|))|$)`,"g"),Me=/'/g,_e=/"/g,Ue=/^(?:script|style|textarea|title)$/i,te=e=>(t,...s)=>({_$litType$:e,strings:t,values:s}),p=te(1),A=te(2),Yi=te(3),rt=Symbol.for("lit-noChange"),z=Symbol.for("lit-nothing"),Ae=new WeakMap,Y=X.createTreeWalker(X,129);function ze(e,t){if(!Qt(e)||!e.hasOwnProperty("raw"))throw Error("invalid template strings array");return ye!==void 0?ye.createHTML(t):t}var Os=(e,t)=>{let s=e.length-1,i=[],a,n=t===2?"<svg>":t===3?"<math>":"",o=at;for(let r=0;r<s;r++){let l=e[r],c,u,h=-1,f=0;for(;f<l.length&&(o.lastIndex=f,u=o.exec(l),u!==null);)f=o.lastIndex,o===at?u[1]==="!--"?o=xe:u[1]!==void 0?o=ke:u[2]!==void 0?(Ue.test(u[2])&&(a=RegExp("</"+u[2],"g")),o=V):u[3]!==void 0&&(o=V):o===V?u[0]===">"?(o=a??at,h=-1):u[1]===void 0?h=-2:(h=o.lastIndex-u[2].length,c=u[1],o=u[3]===void 0?V:u[3]==='"'?_e:Me):o===_e||o===Me?o=V:o===xe||o===ke?o=at:(o=V,a=void 0);let v=o===V&&e[r+1].startsWith("/>")?" ":"";n+=o===at?l+Ts:h>=0?(i.push(c),l.slice(0,h)+Se+l.slice(h)+j+v):l+j+(h===-2?r:v)}return[ze(e,n+(e[s]||"<?>")+(t===2?"</svg>":t===3?"</math>":"")),i]},lt=class e{constructor({strings:t,_$litType$:s},i){let a;this.parts=[];let n=0,o=0,r=t.length-1,l=this.parts,[c,u]=Os(t,s);if(this.el=e.createElement(c,i),Y.currentNode=this.el.content,s===2||s===3){let h=this.el.content.firstChild;h.replaceWith(...h.childNodes)}for(;(a=Y.nextNode())!==null&&l.length<r;){if(a.nodeType===1){if(a.hasAttributes())for(let h of a.getAttributeNames())if(h.endsWith(Se)){let f=u[o++],v=a.getAttribute(h).split(j),m=/([.?@])?(.*)/.exec(f);l.push({type:1,index:n,name:m[2],strings:v,ctor:m[1]==="."?Yt:m[1]==="?"?Xt:m[1]==="@"?Jt:Q}),a.removeAttribute(h)}else h.startsWith(j)&&(l.push({type:6,index:n}),a.removeAttribute(h));if(Ue.test(a.tagName)){let h=a.textContent.split(j),f=h.length-1;if(f>0){a.textContent=kt?kt.emptyScript:"";for(let v=0;v<f;v++)a.append(h[v],nt()),Y.nextNode(),l.push({type:2,index:++n});a.append(h[f],nt())}}}else if(a.nodeType===8)if(a.data===Pe)l.push({type:2,index:n});else{let h=-1;for(;(h=a.data.indexOf(j,h+1))!==-1;)l.push({type:7,index:n}),h+=j.length-1}n++}}static createElement(t,s){let i=X.createElement("template");return i.innerHTML=t,i}};function Z(e,t,s=e,i){if(t===rt)return t;let a=i!==void 0?s._$Co?.[i]:s._$Cl,n=ot(t)?void 0:t._$litDirective$;return a?.constructor!==n&&(a?._$AO?.(!1),n===void 0?a=void 0:(a=new n(e),a._$AT(e,s,i)),i!==void 0?(s._$Co??=[])[i]=a:s._$Cl=a),a!==void 0&&(t=Z(e,a._$AS(e,t.values),a,i)),t}var Vt=class{constructor(t,s){this._$AV=[],this._$AN=void 0,this._$AD=t,this._$AM=s}get parentNode(){return this._$AM.parentNode}get _$AU(){return this._$AM._$AU}u(t){let{el:{content:s},parts:i}=this._$AD,a=(t?.creationScope??X).importNode(s,!0);Y.currentNode=a;let n=Y.nextNode(),o=0,r=0,l=i[0];for(;l!==void 0;){if(o===l.index){let c;l.type===2?c=new ct(n,n.nextSibling,this,t):l.type===1?c=new l.ctor(n,l.name,l.strings,this,t):l.type===6&&(c=new Kt(n,this,t)),this._$AV.push(c),l=i[++r]}o!==l?.index&&(n=Y.nextNode(),o++)}return Y.currentNode=X,a}p(t){let s=0;for(let i of this._$AV)i!==void 0&&(i.strings!==void 0?(i._$AI(t,i,s),s+=i.strings.length-2):i._$AI(t[s])),s++}},ct=class e{get _$AU(){return this._$AM?._$AU??this._$Cv}constructor(t,s,i,a){this.type=2,this._$AH=z,this._$AN=void 0,this._$AA=t,this._$AB=s,this._$AM=i,this.options=a,this._$Cv=a?.isConnected??!0}get parentNode(){let t=this._$AA.parentNode,s=this._$AM;return s!==void 0&&t?.nodeType===11&&(t=s.parentNode),t}get startNode(){return this._$AA}get endNode(){return this._$AB}_$AI(t,s=this){t=Z(this,t,s),ot(t)?t===z||t==null||t===""?(this._$AH!==z&&this._$AR(),this._$AH=z):t!==this._$AH&&t!==rt&&this._(t):t._$litType$!==void 0?this.$(t):t.nodeType!==void 0?this.T(t):Es(t)?this.k(t):this._(t)}O(t){return this._$AA.parentNode.insertBefore(t,this._$AB)}T(t){this._$AH!==t&&(this._$AR(),this._$AH=this.O(t))}_(t){this._$AH!==z&&ot(this._$AH)?this._$AA.nextSibling.data=t:this.T(X.createTextNode(t)),this._$AH=t}$(t){let{values:s,_$litType$:i}=t,a=typeof i=="number"?this._$AC(t):(i.el===void 0&&(i.el=lt.createElement(ze(i.h,i.h[0]),this.options)),i);if(this._$AH?._$AD===a)this._$AH.p(s);else{let n=new Vt(a,this),o=n.u(this.options);n.p(s),this.T(o),this._$AH=n}}_$AC(t){let s=Ae.get(t.strings);return s===void 0&&Ae.set(t.strings,s=new lt(t)),s}k(t){Qt(this._$AH)||(this._$AH=[],this._$AR());let s=this._$AH,i,a=0;for(let n of t)a===s.length?s.push(i=new e(this.O(nt()),this.O(nt()),this,this.options)):i=s[a],i._$AI(n),a++;a<s.length&&(this._$AR(i&&i._$AB.nextSibling,a),s.length=a)}_$AR(t=this._$AA.nextSibling,s){for(this._$AP?.(!1,!0,s);t!==this._$AB;){let i=be(t).nextSibling;be(t).remove(),t=i}}setConnected(t){this._$AM===void 0&&(this._$Cv=t,this._$AP?.(t))}},Q=class{get tagName(){return this.element.tagName}get _$AU(){return this._$AM._$AU}constructor(t,s,i,a,n){this.type=1,this._$AH=z,this._$AN=void 0,this.element=t,this.name=s,this._$AM=a,this.options=n,i.length>2||i[0]!==""||i[1]!==""?(this._$AH=Array(i.length-1).fill(new String),this.strings=i):this._$AH=z}_$AI(t,s=this,i,a){let n=this.strings,o=!1;if(n===void 0)t=Z(this,t,s,0),o=!ot(t)||t!==this._$AH&&t!==rt,o&&(this._$AH=t);else{let r=t,l,c;for(t=n[0],l=0;l<n.length-1;l++)c=Z(this,r[i+l],s,l),c===rt&&(c=this._$AH[l]),o||=!ot(c)||c!==this._$AH[l],c===z?t=z:t!==z&&(t+=(c??"")+n[l+1]),this._$AH[l]=c}o&&!a&&this.j(t)}j(t){t===z?this.element.removeAttribute(this.name):this.element.setAttribute(this.name,t??"")}},Yt=class extends Q{constructor(){super(...arguments),this.type=3}j(t){this.element[this.name]=t===z?void 0:t}},Xt=class extends Q{constructor(){super(...arguments),this.type=4}j(t){this.element.toggleAttribute(this.name,!!t&&t!==z)}},Jt=class extends Q{constructor(t,s,i,a,n){super(t,s,i,a,n),this.type=5}_$AI(t,s=this){if((t=Z(this,t,s,0)??z)===rt)return;let i=this._$AH,a=t===z&&i!==z||t.capture!==i.capture||t.once!==i.once||t.passive!==i.passive,n=t!==z&&(i===z||a);a&&this.element.removeEventListener(this.name,this,i),n&&this.element.addEventListener(this.name,this,t),this._$AH=t}handleEvent(t){typeof this._$AH=="function"?this._$AH.call(this.options?.host??this.element,t):this._$AH.handleEvent(t)}},Kt=class{constructor(t,s,i){this.element=t,this.type=6,this._$AN=void 0,this._$AM=s,this.options=i}get _$AU(){return this._$AM._$AU}_$AI(t){Z(this,t)}};var Bs=Zt.litHtmlPolyfillSupport;Bs?.(lt,ct),(Zt.litHtmlVersions??=[]).push("3.3.3");var Te=(e,t,s)=>{let i=s?.renderBefore??t,a=i._$litPart$;if(a===void 0){let n=s?.renderBefore??null;i._$litPart$=a=new ct(t.insertBefore(nt(),n),n,void 0,s??{})}return a._$AI(e),a};var ht=Math.PI/180,tt=(e,t=0)=>[Math.sin(e)*Math.cos(t),Math.sin(e)*Math.sin(t),Math.cos(e)];function ut(e){let t=new Float32Array(12*e.length);return e.forEach(([s,i,a=[.5,.5]],n)=>{t.set(s,12*n),t.set(i,12*n+4),t.set(a,12*n+8)}),t}function Cs(e){let t=new Set;for(let s=-90;s<=90;s+=1.5)t.add(s);for(let s=0,i=.02;s<26;s++,i*=1.3)for(let a of[e-i,e+i])Math.abs(a)<90&&t.add(a);return t.add(e),[...t].sort((s,i)=>s-i)}var ee=Array.from({length:61},(e,t)=>Math.min(1.5*t,89.9)),G=44;function Ns(e,t){let s=tt(t,Math.PI/2),[i,a]=[Math.cos(e),Math.sin(e)],n=[i*s[0]+a*s[2],s[1],i*s[2]-a*s[0]],o=[a,0,i],r=2*(n[0]*o[0]+n[1]*o[1]+n[2]*o[2]),l=n.map((c,u)=>r*o[u]-c);return n[2]>0&&l[2]>0?[n,l]:null}async function Ee(e,t,s){let{program:i}=t,a=t.packed(),n=tt(s*ht,Math.PI),o=Cs(s),r=[];for(let m=0;m<G;m++)for(let d=0;d<G;d++)r.push(Ns((d+.5)/G*90*ht,(1-(m+.5)/G)*90*ht));let l=[...o.map(m=>[tt(m*ht),n]),...r.map(m=>m??[[0,0,-1],[0,0,1]])],c=await e.rows(i,a,ut(l)),u=o.map((m,d)=>({angle:m,f:[...c.subarray(8*d,8*d+3)],pdf:c[8*d+3]})),h=r.map((m,d)=>m?[...c.subarray(8*(o.length+d),8*(o.length+d)+3)]:null),f=new Float32Array(4*ee.length);ee.forEach((m,d)=>f.set(tt(m*ht),4*d));let v=await e.albedo(i,a,f);return{thetaO:s,slice:u,map:h,albedo:ee.map((m,d)=>({angle:m,value:[...v.subarray(4*d,4*d+3)]}))}}var ft=`//BEGIN
fn texel_of(second: bool,x: i32,y: i32) -> vec3f {
let k: i32 = select(0,1,second);
let w: i32 = i32(D[k].z);
let h: i32 = i32(D[k].w);
let cx: i32 = clamp(x,0,w - 1);
let cy: i32 = clamp(y,0,h - 1);
return film_at(second,cx,cy,w).rgb*select(D[2].x,D[2].y,second);
}
fn picture(second: bool,at: vec2f) -> vec3f {
let k: i32 = select(0,1,second);
let wide: f32 = D[3].x/D[3].y*select(1.0,0.5,D[0].x==3.0);
let film_wide: f32 = D[k].z/D[k].w;
let fit: vec2f = max(vec2f(wide,1.0/wide),vec2f(1.0))/max(vec2f(film_wide,1.0/film_wide),vec2f(1.0));
let q: vec2f = ((at - 0.5)*fit+0.5)*D[k].zw - 0.5;
let low: vec2f = floor(q);
let f: vec2f = q - low;
let x: i32 = i32(low.x);
let y: i32 = i32(low.y);
return mix(mix(texel_of(second,x,y),texel_of(second,x+1,y),f.x),
mix(texel_of(second,x,y+1),texel_of(second,x+1,y+1),f.x),f.y);
}
fn toned(x: vec3f) -> vec3f {
let tone: i32 = i32(D[1].y);
let y: f32 = dot(x,vec3f(0.2126,0.7152,0.0722));
if (tone==1) { return x*((1.0+y/16.0)/(1.0+y)); }
if (tone==2) {
let white: f32 = 1.379064;
let v: vec3f = 2.0*x;
return white*((v*(0.15*v+0.05)+0.004)/(v*(0.15*v+0.5)+0.06) - 0.0666667);
}
return x;
}
fn encoded(x: f32) -> f32 {
let y: f32 = clamp(x,0.0,1.0);
return select(1.055*pow(max(y,1e-9),1.0/2.4) - 0.055,12.92*y,y<0.0031308);
}
fn screen(at: vec2f) -> vec4f {
let mode: i32 = i32(D[0].x);
var place: vec2f = at;
var second: bool = mode==1;
if (mode==2) { second = at.x>D[0].y; }
if (mode==3) { second = at.x>0.5; place.x = fract(at.x*2.0); }
var x: vec3f = picture(second,place);
if (mode==4) { x = 10.0*abs(picture(true,at) - picture(false,at)); }
else { x = toned(x*D[1].x); }
let noise: f32 = fract(52.9829189*fract(dot(at*4096.0,vec2f(0.06711056,0.00583715)))) - 0.5;
return vec4f(vec3f(encoded(x.x),encoded(x.y),encoded(x.z))+noise/255.0,1.0);
}
//END
`;var se=`//BEGIN
struct ModelSample { wi: vec3f,pdf: f32 }
fn model_whole(x: f32) -> f32 {
return select(x,0.0,(bitcast<u32>(x) & 0x7f800000u)==0x7f800000u);
}
fn model_eval(m: Model,wi: vec3f,wo: vec3f) -> vec3f {
if (min(wi.z,wo.z)<=1e-18) { return vec3f(0.0); }
let f: vec3f = model_value(m,wi,wo);
return vec3f(model_whole(f.x),model_whole(f.y),model_whole(f.z));
}
fn model_pdf(m: Model,wi: vec3f,wo: vec3f) -> f32 {
if (min(wi.z,wo.z)<=1e-18) { return 0.0; }
let both: vec3f = wi+wo;
let h: vec3f = both/max(length(both),1e-20);
let theta: f32 = max(atan2(length(h.xy),h.z),1e-5);
let t: f32 = sqrt(sqrt(theta/1.57079633));
let crowded: f32 = 1.0/(6.28318531*sin(theta)*6.28318531*t*t*t);
return 0.5*(wi.z/3.14159265+crowded/(4.0*max(dot(h,wo),1e-6)));
}
fn model_around(m: Model,wo: vec3f,u: vec2f,crowd: bool) -> vec3f {
let phi: f32 = 6.28318531*u.y;
if (!crowd) {
let r: f32 = sqrt(u.x);
return vec3f(r*cos(phi),r*sin(phi),sqrt(max(1.0 - u.x,1e-12)));
}
let theta: f32 = 1.57079633*u.x*u.x*u.x*u.x;
let h: vec3f = vec3f(sin(theta)*cos(phi),sin(theta)*sin(phi),cos(theta));
return 2.0*dot(h,wo)*h - wo;
}
fn model_sample(m: Model,wo: vec3f,u: vec2f) -> ModelSample {
let crowd: bool = u.x>=0.5;
let part: f32 = select(2.0*u.x,2.0*u.x - 1.0,crowd);
let wi: vec3f = model_around(m,wo,vec2f(part,u.y),crowd);
return ModelSample(wi,model_pdf(m,wi,wo));
}
fn model_albedo(m: Model,wo: vec3f) -> vec3f {
var total: vec3f = vec3f(0.0);
for (var k: i32 = 0; k<1600; k++) {
let u: vec2f = vec2f((f32(k % 40)+0.5)/40.0,(f32(k/40)+0.5)/40.0);
for (var rule: i32 = 0; rule<2; rule++) {
let wi: vec3f = model_around(m,wo,u,rule==1);
let p: f32 = model_pdf(m,wi,wo);
if (p>0.0) { total+=model_eval(m,wi,wo)*(wi.z/(2.0*p)); }
}
}
return total/1600.0;
}
//END
`;var dt=`//BEGIN
fn values_at(wi: vec3f,wo: vec3f) -> vec4f {
let m: Model = model_load(P);
return vec4f(model_eval(m,wi,wo),model_pdf(m,wi,wo));
}
fn drawn_at(wo: vec3f,u: vec2f) -> vec4f {
let s: ModelSample = model_sample(model_load(P),wo,u);
return vec4f(s.wi,s.pdf);
}
//END
`;var mt=`@group(0) @binding(0) var<uniform> U: array<vec4f,52>;
@group(0) @binding(1) var<uniform> P: array<vec4f,MEMBERS>;
@group(0) @binding(2) var<storage,read> nodes: array<vec4f>;
@group(0) @binding(3) var<storage,read> places: array<vec4f>;
@group(0) @binding(4) var<storage,read> looks: array<vec4f>;
@group(0) @binding(5) var<storage,read> alias_table: array<vec4f>;
@group(0) @binding(6) var sky: texture_2d<f32>;
@group(0) @binding(7) var maps: texture_2d_array<f32>;
@group(0) @binding(8) var<storage,read> before: array<vec4f>;
@group(0) @binding(9) var<storage,read_write> film: array<vec4f>;
//BEGIN
const TAU: f32 = 6.2831853;
const FAR: f32 = 1e30;
fn map_texel(at: vec2i,layer: i32) -> vec4f {
let size: vec2i = vec2i(textureDimensions(maps).xy);
return textureLoad(maps,((at % size)+size) % size,layer,0);
}
fn map_nearest(uv: vec2f,layer: i32) -> vec4f {
return map_texel(vec2i(floor(uv*vec2f(textureDimensions(maps).xy))),layer);
}
fn map_linear(uv: vec2f,layer: i32) -> vec4f {
let at: vec2f = uv*vec2f(textureDimensions(maps).xy) - 0.5;
let low: vec2f = floor(at);
let k: vec2i = vec2i(low);
let f: vec2f = at - low;
return mix(mix(map_texel(k,layer),map_texel(k+vec2i(1,0),layer),f.x),
mix(map_texel(k+vec2i(0,1),layer),map_texel(k+vec2i(1,1),layer),f.x),f.y);
}
//MODEL
fn hash(x0: u32) -> u32 {
var x: u32 = x0;
x ^= x >> 16u; x*=0x7feb352du; x ^= x >> 15u; x*=0x846ca68bu; x ^= x >> 16u;
return x;
}
fn owen(x0: u32,seed: u32) -> u32 {
var x: u32 = reverseBits(x0);
x ^= x*0x3d20adeau; x+=seed; x*=(seed >> 16u) | 1u; x ^= x*0x05526c56u; x ^= x*0x53a22864u;
return reverseBits(x);
}
fn sobol2(index: u32) -> vec2u {
var second: u32 = 0u;
var column: u32 = 0x80000000u;
for (var i: u32 = index; i != 0u; i >>= 1u) {
if ((i & 1u) != 0u) { second ^= column; }
column ^= column >> 1u;
}
return vec2u(reverseBits(index),second);
}
var<private> pixel_seed: u32;
fn unit2(pair: u32) -> vec2f {
let seed: u32 = hash(pixel_seed ^ (pair*0x9e3779b9u));
let point: vec2u = sobol2(owen(u32(U[0].z),seed));
let x: u32 = owen(point.x,hash(seed ^ 0x68bc21ebu));
let y: u32 = owen(point.y,hash(seed ^ 0x02e5be93u));
return vec2f(f32(x >> 8u),f32(y >> 8u))*(1.0/16777216.0);
}
struct Hit { t: f32,what: i32,u: f32,v: f32 }
fn away_from_zero(x: f32) -> f32 { return select(x,1e-12,abs(x)<1e-12); }
fn box(o: vec3f,inv: vec3f,low: vec3f,high: vec3f,far: f32) -> f32 {
let a: vec3f = (low - o)*inv;
let b: vec3f = (high - o)*inv;
let near: vec3f = min(a,b);
let away: vec3f = max(a,b);
let t0: f32 = max(max(near.x,near.y),max(near.z,0.0));
let t1: f32 = min(min(away.x,away.y),min(away.z,far));
return select(FAR,t0,t0<=t1*1.0000004);
}
fn ball(o: vec3f,d: vec3f,far: f32) -> f32 {
let c: vec3f = U[8].xyz - o;
let b: f32 = dot(c,d);
let e: vec3f = c - b*d;
let q: f32 = U[8].w*U[8].w - dot(e,e);
if (q<=0.0||U[8].w<=0.0) { return FAR; }
let s: f32 = sqrt(q);
let t: f32 = select(b - s,b+s,b - s<1e-4);
return select(FAR,t,t>1e-4&&t<far);
}
fn lamp_count() -> i32 { return i32(U[6].z); }
fn turned(v: vec3f,sense: f32) -> vec3f {
let s: f32 = U[6].y*sense;
return vec3f(U[6].x*v.x+s*v.z,v.y,U[6].x*v.z - s*v.x);
}
fn meet(o: vec3f,d: vec3f,far: f32,any: bool) -> Hit {
var hit: Hit = Hit(far,-1,0.0,0.0);
let t_ball: f32 = ball(o,d,hit.t);
if (t_ball<hit.t) { hit = Hit(t_ball,-2,0.0,0.0); if (any) { return hit; } }
for (var k: i32 = 0; k<lamp_count(); k++) {
let c: vec3f = U[12+5*k].xyz;
let a: vec3f = U[13+5*k].xyz;
let b: vec3f = U[14+5*k].xyz;
let n: vec3f = U[16+5*k].xyz;
let down: f32 = dot(n,d);
let t: f32 = dot(n,c - o)/select(down,1e-20,down==0.0);
if (t>1e-3&&t<hit.t) {
let q: vec3f = o+t*d - c;
let x: f32 = dot(q,a)/dot(a,a);
let y: f32 = dot(q,b)/dot(b,b);
let inside: f32 = select(max(abs(x),abs(y)),sqrt(x*x+y*y),U[12+5*k].w>0.5);
if (inside<=1.0) { hit = Hit(t,-3 - k,0.0,0.0); if (any) { return hit; } }
}
}
if (U[7].y<1.0) { return hit; }
let inv: vec3f = 1.0/vec3f(away_from_zero(d.x),away_from_zero(d.y),away_from_zero(d.z));
var stack: array<i32,40>;
var top: i32 = 0;
var at: i32 = 0;
if (box(o,inv,nodes[0].xyz,nodes[1].xyz,hit.t)>=FAR) { return hit; }
loop {
let first: i32 = i32(nodes[2*at].w);
let count: i32 = i32(nodes[2*at+1].w);
if (count>0) {
for (var i: i32 = first; i<first+count; i++) {
let e1: vec3f = places[3*i+1].xyz;
let e2: vec3f = places[3*i+2].xyz;
let h: vec3f = cross(d,e2);
let a: f32 = dot(e1,h);
if (abs(a)>1e-14) {
let f: f32 = 1.0/a;
let s: vec3f = o - places[3*i].xyz;
let u: f32 = f*dot(s,h);
let q: vec3f = cross(s,e1);
let v: f32 = f*dot(d,q);
let t: f32 = f*dot(e2,q);
if (u>=0.0&&v>=0.0&&u+v<=1.0&&t>1e-4&&t<hit.t) {
hit = Hit(t,i,u,v);
if (any) { return hit; }
}
}
}
if (top==0) { break; }
top--; at = stack[top];
} else {
var one: i32 = first;
var two: i32 = first+1;
var t1: f32 = box(o,inv,nodes[2*one].xyz,nodes[2*one+1].xyz,hit.t);
var t2: f32 = box(o,inv,nodes[2*two].xyz,nodes[2*two+1].xyz,hit.t);
if (t2<t1) { let k: i32 = one; one = two; two = k; let t: f32 = t1; t1 = t2; t2 = t; }
if (t1>=FAR) { if (top==0) { break; } top--; at = stack[top]; }
else { at = one; if (t2<FAR) { stack[top] = two; top++; } }
}
}
return hit;
}
fn ground_at(o: vec3f,d: vec3f) -> f32 {
let t: f32 = -o.y/select(d.y,1e-20,d.y==0.0);
return select(FAR,t,U[7].w>0.0&&t>1e-4);
}
fn ground_share(p: vec3f) -> f32 {
let t: f32 = clamp((length(p.xz) - U[7].z)/max(U[7].w - U[7].z,1e-6),0.0,1.0);
let x: f32 = 1.0 - t*t*(3.0 - 2.0*t);
return x*x;
}
fn sky_texel(x: i32,y: i32) -> vec3f {
let w: i32 = i32(U[10].x);
return textureLoad(sky,vec2i(((x % w)+w) % w,clamp(y,0,i32(U[10].y) - 1)),0).rgb;
}
fn sky_place(d: vec3f) -> vec2f {
let w: vec3f = turned(d,-1.0);
return vec2f(fract(atan2(-w.x,w.z)/TAU),acos(clamp(w.y,-1.0,1.0))/(0.5*TAU))*U[10].xy;
}
fn surround(d: vec3f) -> vec3f {
if (U[5].w<0.5) { return U[5].xyz; }
let at: vec2f = sky_place(d) - 0.5;
let low: vec2f = floor(at);
let f: vec2f = at - low;
let k: vec2i = vec2i(low);
let value: vec3f = mix(mix(sky_texel(k.x,k.y),sky_texel(k.x+1,k.y),f.x),
mix(sky_texel(k.x,k.y+1),sky_texel(k.x+1,k.y+1),f.x),f.y);
return value*U[5].xyz;
}
fn sky_pdf(d: vec3f) -> f32 {
let at: vec2u = min(vec2u(sky_place(d)),vec2u(U[10].xy) - 1u);
return U[6].w*alias_table[at.y*u32(U[10].x)+at.x].z;
}
fn lamp_weight(k: i32,o: vec3f,n: vec3f) -> f32 {
let way: vec3f = U[12+5*k].xyz - o;
let square: f32 = max(dot(way,way),1e-6);
let d: vec3f = way/sqrt(square);
let above: f32 = clamp(dot(n,d)+sqrt(U[13+5*k].w/square),0.05,1.0);
return U[15+5*k].w*(0.1+max(-dot(U[16+5*k].xyz,d),0.0))*above/square;
}
struct Choice { k: i32,share: f32 }
fn choose(o: vec3f,n: vec3f,u: f32,known: i32) -> Choice {
var found: Choice = Choice(max(known,0),0.0);
var total: f32 = 0.0;
var rest: f32 = u;
for (var k: i32 = 0; k<lamp_count(); k++) {
let weight: f32 = lamp_weight(k,o,n);
total+=weight;
let p: f32 = weight/total;
if (k==known||(known<0&&rest<p)) { found = Choice(k,weight); rest/=p; }
else { rest = (rest - p)/max(1.0 - p,1e-20); }
}
found.share/=max(total,1e-20);
return found;
}
fn lamp_pdf(lamp: Choice,t: f32,d: vec3f) -> f32 {
let seen: f32 = max(-dot(U[16+5*lamp.k].xyz,d),1e-6)*U[13+5*lamp.k].w;
return (1.0 - U[6].w)*lamp.share*t*t/seen;
}
struct Light { d: vec3f,far: f32,radiance: vec3f,pdf: f32 }
fn sample_light(o: vec3f,normal: vec3f,u: vec2f,choice: vec2f) -> Light {
if (choice.x<U[6].w) {
let size: vec2u = vec2u(U[10].xy);
let x: f32 = choice.x/U[6].w*f32(size.x*size.y);
let cell: u32 = min(u32(x),size.x*size.y - 1u);
let entry: vec4f = alias_table[cell];
let k: u32 = select(u32(entry.y),cell,choice.y<entry.x);
let place: vec2f = vec2f(f32(k % size.x)+u.x,f32(k/size.x)+u.y)/U[10].xy;
let th: f32 = place.y*0.5*TAU;
let ph: f32 = place.x*TAU;
let d: vec3f = turned(vec3f(-sin(th)*sin(ph),cos(th),sin(th)*cos(ph)),1.0);
return Light(d,FAR,vec3f(1.0),U[6].w*alias_table[k].z);
}
let lamp: Choice = choose(o,normal,(choice.x - U[6].w)/(1.0 - U[6].w),-1);
let k: i32 = lamp.k;
var s: vec2f = 2.0*u - 1.0;
if (U[12+5*k].w>0.5) { s = sqrt(u.x)*vec2f(cos(TAU*u.y),sin(TAU*u.y)); }
let way: vec3f = U[12+5*k].xyz+s.x*U[13+5*k].xyz+s.y*U[14+5*k].xyz - o;
let t: f32 = length(way);
let d: vec3f = way/t;
if (dot(U[16+5*k].xyz,d)>=0.0||lamp_count()<1) { return Light(d,0.0,vec3f(0.0),0.0); }
return Light(d,t*0.9999,U[15+5*k].xyz,lamp_pdf(lamp,t,d));
}
fn any_frame(n: vec3f) -> vec3f {
return normalize(cross(select(vec3f(0.0,1.0,0.0),vec3f(1.0,0.0,0.0),abs(n.y)>0.99),n));
}
fn path(origin: vec3f,direction: vec3f) -> vec3f {
var o: vec3f = origin;
var d: vec3f = direction;
var L: vec3f = vec3f(0.0);
var T: vec3f = vec3f(1.0);
var pdf: f32 = -1.0;
var facing: vec3f = vec3f(0.0);
let furnace: bool = U[3].w>0.5;
let way: i32 = i32(U[9].z);
let depth: i32 = i32(U[4].w);
var far: f32 = FAR;
var waiting: vec3f = vec3f(0.0);
var shadow: bool = false;
var onward: vec3f = vec3f(0.0);
var b: i32 = 0;
for (var i: i32 = 0; i<2*depth; i++) {
var hit: Hit = meet(o,d,far,shadow);
let t_ground: f32 = ground_at(o,d);
let covered: f32 = select(0.0,ground_share(o+t_ground*d),t_ground<hit.t);
let u_end: vec2f = unit2(u32(4*b+4));
if (!shadow&&u_end.y<covered) { hit = Hit(t_ground,1 << 30,0.0,0.0); }
if (hit.what==-1&&far==FAR) {
var w: f32 = 1.0;
if (!shadow&&U[6].w>0.0&&pdf>=0.0) { w = pdf/(pdf+sky_pdf(d)); if (way==1) { w = 1.0; } if (way==2) { w = 0.0; } }
waiting = select(T,waiting,shadow)*surround(d)*w;
}
if (shadow) {
if (hit.what==-1) { L+=waiting*(1.0 - covered); }
if (dot(onward,onward)==0.0) { break; }
shadow = false;
far = FAR;
d = onward;
b++;
continue;
}
if (hit.what==-1) { L+=waiting; break; }
if (hit.what<-2) {
let k: i32 = -3 - hit.what;
if (dot(U[16+5*k].xyz,d)<0.0) {
var w: f32 = 1.0;
if (pdf>=0.0) { w = pdf/(pdf+lamp_pdf(choose(o,facing,0.0,k),hit.t,d)); if (way==1) { w = 1.0; } if (way==2) { w = 0.0; } }
L+=T*U[15+5*k].xyz*w;
}
break;
}
if (b==depth - 1) { break; }
let x: vec3f = o+hit.t*d;
var p: vec3f = x;
var ng: vec3f;
var n: vec3f;
var du: vec3f;
var uv: vec2f = vec2f(0.0);
var growth: f32 = 0.5;
var kind: i32 = 0;
if (hit.what==1 << 30) {
ng = vec3f(0.0,1.0,0.0);
n = ng;
du = vec3f(1.0,0.0,0.0);
kind = 3;
} else if (hit.what==-2) {
n = normalize(x - U[8].xyz);
ng = n;
du = vec3f(-n.z,0.0,n.x);
uv = vec2f(fract(atan2(-n.x,-n.z)/TAU+1.0),acos(clamp(n.y,-1.0,1.0))/(0.5*TAU));
p = U[8].xyz+U[8].w*n;
} else {
let i: i32 = hit.what;
let p0: vec3f = places[3*i].xyz;
let e1: vec3f = places[3*i+1].xyz;
let e2: vec3f = places[3*i+2].xyz;
let n0: vec3f = looks[5*i].xyz;
let n1: vec3f = looks[5*i+1].xyz;
let n2: vec3f = looks[5*i+2].xyz;
let a: f32 = 1.0 - hit.u - hit.v;
kind = i32(places[3*i].w);
ng = normalize(cross(e1,e2));
n = normalize(a*n0+hit.u*n1+hit.v*n2);
growth = a*looks[5*i].w+hit.u*looks[5*i+1].w+hit.v*looks[5*i+2].w;
let t01: vec4f = looks[5*i+3];
let t2: vec2f = looks[5*i+4].xy;
uv = a*t01.xy+hit.u*t01.zw+hit.v*t2;
let s1: vec2f = t01.zw - t01.xy;
let s2: vec2f = t2 - t01.xy;
du = (e1*s2.y - e2*s1.y)*sign(s1.x*s2.y - s1.y*s2.x);
p = p0+hit.u*e1+hit.v*e2;
let side: f32 = select(-1.0,1.0,dot(ng,d)<0.0);
let q0: vec3f = p - p0;
let q1: vec3f = q0 - e1;
let q2: vec3f = q0 - e2;
let l0: f32 = min(0.0,side*dot(q0,n0));
let l1: f32 = min(0.0,side*dot(q1,n1));
let l2: f32 = min(0.0,side*dot(q2,n2));
if (kind==0) { p-=side*(a*l0*n0+hit.u*l1*n1+hit.v*l2*n2); }
}
if (kind==0) {
let bump: vec3f = normal_at(uv);
if (abs(bump.x)+abs(bump.y)>1e-4) {
let across: vec3f = du - dot(du,n)*n;
let u_axis: vec3f = select(any_frame(n),across/max(length(across),1e-20),dot(across,across)>1e-16);
n = normalize(bump.x*u_axis+bump.y*cross(n,u_axis)+bump.z*n);
}
}
if (dot(ng,d)>0.0) { ng = -ng; n = -n; }
let below: f32 = dot(n,d);
if (below>-1e-3) { n = normalize(n - (below+1e-3)*d); }
du = du - dot(du,n)*n;
let tx: vec3f = select(any_frame(n),du/max(length(du),1e-20),dot(du,du)>1e-16);
let ty: vec3f = cross(n,tx);
let wo: vec3f = vec3f(-dot(d,tx),-dot(d,ty),-dot(d,n));
p+=1e-4*ng;
let u_light: vec2f = unit2(u32(4*b+1));
let u_choice: vec2f = unit2(u32(4*b+2));
let u_model: vec2f = unit2(u32(4*b+3));
let test: bool = kind==0;
let grey: vec3f = select(vec3f(select(0.12,0.32,kind==1)),U[11].xyz,kind==3)/(0.5*TAU);
var m: Model = model_at(uv,growth,hit.t);
var next: vec3f = vec3f(sqrt(u_model.x)*vec2f(cos(TAU*u_model.y),sin(TAU*u_model.y)),sqrt(max(1.0 - u_model.x,1e-12)));
var density: f32 = next.z/(0.5*TAU);
if (test) {
let s: ModelSample = model_sample(m,wo,u_model);
next = s.wi;
density = s.pdf;
}
var light: Light = Light(vec3f(0.0),0.0,vec3f(0.0),0.0);
if (!furnace&&way != 1&&(U[6].w>0.0||lamp_count()>0)) { light = sample_light(p,n,u_light,u_choice); }
let to_light: vec3f = vec3f(dot(light.d,tx),dot(light.d,ty),dot(light.d,n));
var going: vec3f = vec3f(0.0);
waiting = vec3f(0.0);
for (var k: i32 = select(1,0,light.pdf>0.0&&to_light.z>0.0); k<select(1,2,density>0.0); k++) {
let wi: vec3f = select(next,to_light,k==0);
var f: vec3f = grey;
if (test) { f = model_eval(m,wi,wo); }
if (k==0) {
var q: f32 = wi.z/(0.5*TAU);
if (test) { q = model_pdf(m,wi,wo); }
if (way==2) { q = 0.0; }
waiting = T*f*light.radiance*(wi.z/(light.pdf+q));
} else {
going = T*f*(wi.z/density);
}
}
T = going;
pdf = density;
o = p;
facing = n;
onward = vec3f(0.0);
let left: f32 = max(T.x,max(T.y,T.z));
if (left>0.0) {
let keep: f32 = select(1.0,max(left,0.05),!furnace&&b>=2&&left<1.0);
if (u_end.x<keep) {
onward = normalize(tx*next.x+ty*next.y+n*next.z);
T/=keep;
}
}
shadow = max(waiting.x,max(waiting.y,waiting.z))>0.0;
if (shadow) { d = light.d; far = light.far; continue; }
if (dot(onward,onward)==0.0) { break; }
d = onward;
b++;
}
return L;
}
fn pixel(at: vec2u) -> vec4f {
pixel_seed = hash(at.x+hash(at.y+hash(u32(U[0].w))));
let q: vec2f = ((vec2f(at)+unit2(0u))/U[0].xy*2.0 - 1.0)*vec2f(U[2].w,-1.0)*U[1].w;
let L: vec3f = path(U[1].xyz,normalize(U[4].xyz+q.x*U[2].xyz+q.y*U[3].xyz));
let lum: f32 = dot(L,vec3f(0.2126,0.7152,0.0722));
return vec4f(L,lum*lum);
}
//END
@compute @workgroup_size(8,8) fn main(@builtin(global_invocation_id) id: vec3u) {
let size = vec2u(U[0].xy);
let at = vec2u(id.x,id.y+u32(U[9].x));
if (at.x>=size.x||at.y>=min(size.y,u32(U[9].y))) { return; }
let i = at.y*size.x+at.x;
film[i] = select(before[i],vec4f(0.0),U[0].z<0.5)+pixel(at);
}
`;var Fs={wgsl:`fn model_at(uv: vec2f, growth: f32, t: f32) -> Model {
    var m: Model = model_load(P);
`,essl:`Model model_at(vec2 uv, float growth, float t) {
    Model m = model_load(P);
`};function ae(e,t){let s=r=>`uv * ${t==="wgsl"?"vec2f":"vec2"}(${r.scale.map(ie).join(", ")})`,i=e.hooks.find(r=>r.source==="normal_map"),a=i?`2.0 * map_linear(${s(i)}, ${i.layer}).xyz - 1.0`:t==="wgsl"?"vec3f(0.0, 0.0, 1.0)":"vec3(0.0, 0.0, 1.0)",n=t==="wgsl"?`fn normal_at(uv: vec2f) -> vec3f { return ${a}; }
`:`vec3 normal_at(vec2 uv) { return ${a}; }
`,o=e.hooks.filter(r=>r!==i).map(r=>{let l=`m.${r.members[t]}`;if(r.source==="mesh")return`    ${l} = growth;`;if(r.source==="viewer")return`    ${l} = t / ${ie(r.unit)};`;let c=r.source==="flakes"?`map_nearest(uv * ${ie(r.tiles)}, ${r.layer})`:`map_linear(${s(r)}, ${r.layer})`;return`    ${l} = ${c}.${r.width===3?"rgb":"xy"[r.channel]};`});return`${n}${Fs[t]}${o.join(`
`)}
    return m;
}
`}var ie=e=>Number.isInteger(e)?`${e}.0`:String(e),js=[mt,dt,ft,se].join(`
`),Gs=new Set([...js.matchAll(/(?:\bfn|\bconst|\bstruct|\bvar<[^>]*>|\) var) (\w+)/g)].map(e=>e[1]).concat("P","given","made","drawn","D","film_a","film_b","shown","row_of","reverse_bits","main").filter(e=>!/^Model|^model_/.test(e)));function pt(e,t,s=i=>i){let i=e.code[t];return e.foreign&&(i=i.replace(/\b[A-Za-z_]\w*/g,a=>Gs.has(a)?`${a}_user`:a)+s(se).replace(/^.*\/\/BEGIN|\/\/END.*$/gs,"")),`${i}
${e.load[t]}
`}var J=e=>Math.max(1,e.members.length);function Oe(e){return mt.replace("MEMBERS",J(e)).replace("//MODEL",()=>pt(e,"wgsl")+ae(e,"wgsl"))}var Be=e=>`@group(0) @binding(0) var<uniform> P: array<vec4f, ${e}>;
@group(0) @binding(1) var<storage, read> given: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> made: array<vec4f>;
`;function Ce(e){return`${Be(J(e))}${pt(e,"wgsl")}${dt}
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if (3u * i + 2u >= arrayLength(&given)) { return; }
    made[2u * i] = values_at(given[3u * i].xyz, given[3u * i + 1u].xyz);
    made[2u * i + 1u] = drawn_at(given[3u * i + 1u].xyz, given[3u * i + 2u].xy);
}`}function Ne(e){return`${Be(J(e))}${pt(e,"wgsl")}
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&given)) { return; }
    made[id.x] = vec4f(model_albedo(model_load(P), given[id.x].xyz), 0.0);
}`}var Ie=`@group(0) @binding(0) var<uniform> D: array<vec4f, 4>;
@group(0) @binding(1) var<storage, read> film_a: array<vec4f>;
@group(0) @binding(2) var<storage, read> film_b: array<vec4f>;
fn film_at(second: bool, x: i32, y: i32, w: i32) -> vec4f {
    if (second) { return film_b[y * w + x]; }
    return film_a[y * w + x];
}
${ft}
@vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(select(-1.0, 3.0, i == 1u), select(-1.0, 3.0, i == 2u), 0.0, 1.0);
}
@fragment fn pixel(@builtin(position) at: vec4f) -> @location(0) vec4f { return screen(at.xy / D[3].xy); }`;var qs={both:0,model:1,light:2},Le=8,ne=12+5*Le;function Mt([e,t,s],i){let a=i*Math.PI/180,[n,o]=[Math.cos(a),Math.sin(a)];return[n*e+o*s,t,n*s-o*e]}function Re({width:e,height:t,sample:s,seed:i=1,view:a,light:n,furnace:o,scene:r,estimator:l="both",depth:c}){let u=new Float32Array(4*ne),h=(k,...M)=>u.set(M,4*k),{origin:f,forward:v,right:m,up:d,half:g,aspect:w}=a;h(0,e,t,s,i),h(1,...f,g),h(2,...m,w),h(3,...d,o?1:0),h(4,...v,c??(o?256:12));let $=o?[]:n.lamps.slice(0,Le),b=!o&&n.picture;h(5,...o?[1,1,1]:b?[1,1,1].map(k=>k*(n.scale??1)):n.surround,b?1:0);let x=(n.turn??0)*Math.PI/180;return h(6,Math.cos(x),Math.sin(x),$.length,b?$.length?.5:1:0),h(7,0,r.count,...o?[0,0]:n.fade),h(11,...n.groundColour??[0,0,0],0),h(8,...r.core?.centre??[0,0,0],r.core?.radius??0),h(9,0,0,qs[l],0),b&&h(10,b.width,b.height,0,0),$.forEach((k,M)=>{let[y,_,B]=[k.centre,k.a,k.b].map(N=>Mt(N,n.turn??0)),E=[0,1,2].map(N=>_[(N+1)%3]*B[(N+2)%3]-_[(N+2)%3]*B[(N+1)%3]),F=Math.hypot(...E),P=12+5*M;h(P,...y,k.shape==="disk"?1:0),h(P+1,..._,k.area),h(P+2,...B,0),h(P+3,...k.radiance,k.area*(.2126*k.radiance[0]+.7152*k.radiance[1]+.0722*k.radiance[2])),h(P+4,...E.map(N=>N/F),0)}),u}var vt=e=>e<=.0031308?12.92*Math.max(e,0):1.055*Math.min(e,1)**.4166666666666667-.055,De=e=>e<=.04045?e/12.92:((e+.055)/1.055)**2.4,q=e=>`rgb(${e.map(t=>Math.round(255*vt(t))).join(" ")})`,gt=e=>`#${e.map(t=>Math.round(255*vt(t)).toString(16).padStart(2,"0")).join("").toUpperCase()}`;function _t(e){let t=/^#?([0-9a-f]{6}|[0-9a-f]{3})$/i.exec(e.trim());if(!t)return null;let s=t[1].length===3?[...t[1]].map(i=>i+i).join(""):t[1];return[0,2,4].map(i=>De(parseInt(s.slice(i,i+2),16)/255))}function Fe(e){let[t,s,i]=e.map(vt),a=Math.max(t,s,i),n=a-Math.min(t,s,i);return[(n===0?0:a===t?((s-i)/n+6)%6:a===s?(i-t)/n+2:(t-s)/n+4)*60,a===0?0:n/a,a]}function oe([e,t,s]){let i=a=>{let n=(a+e/60)%6;return s-s*t*Math.max(0,Math.min(n,4-n,1))};return[i(5),i(3),i(1)].map(De)}function je(e,t,{metals:s,indices:i}){let a=new Map,n=new Map(e.map(o=>[o.path,o]));for(let[o,r]of t){let l=n.get(o),c=new Error(`This saved page does not know ${o}=${r}.`);if(l){let u=l.width===3&&r[0]==="#"&&_t(r),h=/(eta|ior)$/.test(o)&&i[r.toLowerCase().replace(/[ -]/g,"_")],f=o.replace(/eta$/,"k");if(a.set(o,u||(h?[h]:r.split("/").map(Number))),a.get(o).some(Number.isNaN))throw c;h&&n.has(f)&&!t.has(f)&&a.set(f,[0])}else if(/(^|\.)metal$/.test(o)){let u=o.slice(0,-5),h=[u,`${o}_`].find(v=>n.has(`${v}eta`)&&n.has(`${v}k`)),f=Object.values(s).find(v=>v.symbol===r);if(h===void 0||!f)throw c;a.set(`${h}eta`,f.eta).set(`${h}k`,f.k)}}return a}function L(e,t){let s=Uint8Array.fromBase64?.(e)??Uint8Array.from(atob(e),i=>i.charCodeAt(0));return new t(s.buffer)}function Ut({rows:e,entries:t}){let s=L(e,Float32Array),i=new Float32Array(4*t);for(let a=0;a<3*t;a++)i[a+Math.floor(a/3)]=s[a];return i}function zt(e){return Float32Array.from(e,t=>{let s=t&32768?-1:1,i=t>>10&31,a=t&1023;return i===0?s*a*2**-24:i===31?a?NaN:s*(1/0):s*(1+a/1024)*2**(i-15)})}var Ge=e=>import(`data:text/javascript;charset=utf-8,${encodeURIComponent(e)}`),At=class{live=!0;constructor(t){this.token=t}async#t(t,s){let i;try{i=await fetch(t,{method:"POST",body:JSON.stringify(s),headers:{"Content-Type":"application/json","X-Gonio-Token":this.token}})}catch{throw new Error("gonio view is not running any more; start it again and reload this page.")}let a=await i.json().catch(()=>({error:`The server answered ${i.status}.`}));if(!i.ok)throw Object.assign(new Error(a.error),a);return a}part(t){return import(`/${t}.js`)}async file(t){return(await fetch(`/${t}`)).text()}start(){return this.#t("/api/start",{})}model(t){return this.#t("/api/model",{text:t})}options(t){return this.#t("/api/options",{text:t})}albedo(t,s){return this.#t("/api/albedo",{text:t,wo:s}).then(i=>i.albedo)}code(t,s){return this.#t("/api/code",{text:t,language:s}).then(i=>i.text)}watch(t){let s=new BroadcastChannel("gonio changes");s.onmessage=({data:a})=>t(a);let i=()=>this.#s(a=>{s.postMessage(a),t(a)});navigator.locks?navigator.locks.request("gonio changes",i):i()}async#s(t){for(let s=!1;;){let i=await fetch("/api/changes",{method:"POST",body:"{}",headers:{"Content-Type":"application/json","X-Gonio-Token":this.token}}).catch(()=>null);if(i&&!i.ok)return;!i!==s&&(s=!i,t({ended:s}));try{let a=i.body.pipeThrough(new TextDecoderStream).getReader();for(let n="";;){let{value:o,done:r}=await a.read();if(r)break;let l=(n+o).split(`

`);n=l.pop();for(let c of l)c.startsWith("data: ")&&t(JSON.parse(c.slice(6)))}}catch{}await new Promise(a=>setTimeout(a,1500))}}},St=class{live=!1;constructor(t){this.data=t}async part(t){return Ge(await this.file(`${t}.js`))}async file(t){return this.data.files[t]}async start(){return this.data}async model(t){if(Object.hasOwn(this.data.models,t))return this.data.models[t];let[s,i=""]=[t.split(":")[0],t.slice(t.indexOf(":")+1)],a=Object.values(this.data.models).find(h=>h.name===s);if(!a){let h=Object.keys(this.data.models);throw new Error(h.length>4?`This saved page holds ${h.length} models and materials, but not this one.`:`This saved page holds ${h.join(" and ")} alone; 'gonio view' has all models.`)}let n=new Map(t.includes(":")?i.split(",").map(h=>[h.slice(0,h.indexOf("=")),h.slice(h.indexOf("=")+1)]):[]);for(let{path:h,value:f,default:v}of a.models)if((n.get(h)??a.start[h]??v)!==f)throw new Error("This saved page has its layers as they are; 'gonio view' changes them.");let o=a.options.map(h=>[h.path,n.get(h.path)??a.start[h.path]??h.default]),r=o.every(([,h],f)=>a.options[f].value===h)?a:this.#t(a,`${s}|${o.map(([h,f])=>`${h}=${f}`).join()}`),l=je(r.parameters,n,this.data),c=[...r.parameters,...a.options,...a.models].map(h=>h.path);for(let h of n.keys())if(!c.includes(h)&&!/(^|\.)metal$/.test(h))throw new Error(`${s} has no '${h}'.`);let u=r.parameters.map(h=>{let f=l.get(h.path)??[a.start[h.path]??h.default].flat();return{...h,value:Array.from({length:h.width},(v,m)=>f[m]??f[0])}});return{...r,parameters:u}}#t(t,s){let i=this.data.variants?.[s];if(!i)throw new Error("This saved page has no shader for that choice; 'gonio view' has them all.");let a=n=>i[n].map(o=>this.data.pool[n][o]).join(`

`);return{...t,...i.about,code:{wgsl:a("wgsl"),essl:a("essl")}}}async code(t,s){let i=(await this.model(t)).code[s];if(i===void 0)throw new Error("This saved page holds WGSL and GLSL ES only; 'gonio view' has every language.");return i}watch(){}},Pt=class{live=!0;#t=new Map;#s=0;constructor(t){this.widget=t,t.on("msg:custom",s=>{let i=this.#t.get(s.id);i&&(this.#t.delete(s.id),s.error?i.reject(new Error(s.error)):i.resolve(s.answer))})}#e(t,s){let i=++this.#s;return this.widget.send({id:i,question:t,body:s}),new Promise((a,n)=>{this.#t.set(i,{resolve:a,reject:n}),setTimeout(()=>{this.#t.delete(i)&&n(new Error("The notebook's kernel does not answer; is it busy?"))},3e4)})}async part(t){return Ge(await this.file(`${t}.js`))}async file(t){return(await this.#e("file",{text:t})).text}start(){return this.#e("start",{})}model(t){return this.#e("model",{text:t})}options(t){return this.#e("options",{text:t})}albedo(t,s){return this.#e("albedo",{text:t,wo:s}).then(i=>i.albedo)}code(t,s){return this.#e("code",{text:t,language:s}).then(i=>i.text)}watch(){}};var Ws=e=>e.filter(t=>t.type==="error").map(t=>`${t.message} (line ${t.lineNum})`)[0],wt=null;async function Vs(){wt??={users:0,coming:Ys()};let e=wt;e.users++;try{return{...await e.coming,taken:e}}catch(t){throw wt=null,t}}async function Ys(){let e=await navigator.gpu.requestAdapter({powerPreference:"high-performance"});if(!e)throw new Error("The browser has WebGPU but no adapter: the driver is blocked or there is no GPU.");let t=Math.min(e.limits.maxStorageBufferBindingSize,1<<30),s=await e.requestDevice({requiredLimits:{maxStorageBufferBindingSize:t,maxBufferSize:Math.min(e.limits.maxBufferSize,1<<30)}});return s.lost.then(()=>{wt=null}),{device:s,adapter:e}}var Tt=class e{name="WebGPU";language="wgsl";static async create(){if(!globalThis.isSecureContext)throw new Error("This page came over http:// from another machine, and browsers give WebGPU to secure contexts only.");if(!navigator.gpu)throw new Error("This browser has no WebGPU.");let{device:t,adapter:s,taken:i}=await Vs();return Object.assign(new e(t,s),{taken:i})}constructor(t,s){this.device=t,this.adapter=s.info?.description||s.info?.vendor||"",this.canvas=document.createElement("canvas"),this.context=this.canvas.getContext("webgpu"),this.format=navigator.gpu.getPreferredCanvasFormat(),this.context.configure({device:t,format:this.format,alphaMode:"opaque"}),this.errors=[],t.addEventListener("uncapturederror",c=>this.errors.push(c.error.message)),this.lost=t.lost;let i=c=>({buffer:{type:c}}),a=i("read-only-storage"),n=[i("uniform"),i("uniform"),a,a,a,a,{texture:{sampleType:"unfilterable-float"}},{texture:{sampleType:"unfilterable-float",viewDimension:"2d-array"}},a,i("storage")];this.traceGroup=t.createBindGroupLayout({entries:n.map((c,u)=>({binding:u,visibility:GPUShaderStage.COMPUTE,...c}))});let o=[i("uniform"),a,i("storage")];this.numberGroup=t.createBindGroupLayout({entries:o.map((c,u)=>({binding:u,visibility:GPUShaderStage.COMPUTE,...c}))}),this.tableGroup=t.createBindGroupLayout({entries:[{binding:8,visibility:GPUShaderStage.COMPUTE,...a}]}),this.settings=t.createBuffer({size:16*ne,usage:GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST}),this.screen=t.createBuffer({size:64,usage:GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST});let r=new Float32Array(8);this.scene={nodes:this.#t(r),places:this.#t(r),looks:this.#t(r)},this.setSky({width:1,height:1,pixels:new Float32Array(4),alias:new Float32Array(4)});let l=t.createShaderModule({code:Ie});this.display=t.createRenderPipeline({layout:"auto",vertex:{module:l,entryPoint:"corner"},fragment:{module:l,entryPoint:"pixel",targets:[{format:this.format}]}})}close(){--this.taken.users===0&&(wt=null,this.device.destroy())}#t(t,s=GPUBufferUsage.STORAGE){let i=this.device.createBuffer({size:Math.max(t.byteLength,16),usage:s|GPUBufferUsage.COPY_DST});return this.device.queue.writeBuffer(i,0,t),i}setScene({nodes:t,places:s,looks:i}){for(let a of Object.values(this.scene))a.destroy();this.scene={nodes:this.#t(t),places:this.#t(s),looks:this.#t(i)}}setSky({width:t,height:s,pixels:i,alias:a}){this.sky?.destroy(),this.alias?.destroy(),this.sky=this.device.createTexture({size:[t,s],format:"rgba32float",usage:GPUTextureUsage.TEXTURE_BINDING|GPUTextureUsage.COPY_DST}),this.device.queue.writeTexture({texture:this.sky},i,{bytesPerRow:16*t},[t,s]),this.alias=this.#t(a)}makeSide(){return{films:[],front:0,width:0,height:0,maps:this.#s({size:1,layers:1,pixels:new Float32Array(4)})}}#s({size:t,layers:s,pixels:i}){let a=this.device.createTexture({size:[t,t,s],format:"rgba32float",usage:GPUTextureUsage.TEXTURE_BINDING|GPUTextureUsage.COPY_DST});return this.device.queue.writeTexture({texture:a},i,{bytesPerRow:16*t,rowsPerImage:t},[t,t,s]),a}setMaps(t,s){t.maps.destroy(),t.maps=this.#s(s)}async compile(t,{trace:s=!0}={}){let i=s?await this.#i(Oe(t),this.traceGroup,t):null,a=this.device.createBuffer({size:16*J(t),usage:GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST}),n={model:t,trace:i,params:a};return t.tables&&(n.tables=this.#t(Ut(t.tables)),n.tableGroup=this.device.createBindGroup({layout:this.tableGroup,entries:[{binding:8,resource:{buffer:n.tables}}]})),s||await this.#e(n),n}async#e(t){t.rows??=await(t.rowsComing??=this.#a(t,Ce))}#a({model:t},s){return this.#i(s(t),this.numberGroup,t)}async#i(t,s,i){let a=this.device.createShaderModule({code:t}),n=this.device.createPipelineLayout({bindGroupLayouts:i.tables?[s,this.tableGroup]:[s]});try{return await this.device.createComputePipelineAsync({layout:n,compute:{module:a,entryPoint:"main"}})}catch(o){throw new Error(Ws((await a.getCompilationInfo()).messages)??o.message)}}forget(t){t.params.destroy(),t.tables?.destroy()}#n(t,s){let i=s.map((a,n)=>({binding:n,resource:a instanceof GPUBuffer?{buffer:a}:a}));return this.device.createBindGroup({layout:t,entries:i})}resize(t,s,i){t.wanted=[s,i]}trace(t,s,i,a,n,o){let[r,l]=t.wanted,c=1-t.front;(t.films[c]?.width!==r||t.films[c]?.height!==l)&&(t.films[c]?.buffer.destroy(),t.films[c]={width:r,height:l,buffer:this.device.createBuffer({size:16*r*l,usage:GPUBufferUsage.STORAGE|GPUBufferUsage.COPY_SRC})});let u=a[2]>0?t.films[t.front].buffer:this.#o();a[36]=n,a[37]=o,this.device.queue.writeBuffer(this.settings,0,a),this.device.queue.writeBuffer(s.params,0,i);let{nodes:h,places:f,looks:v}=this.scene,m=t.maps.createView({dimension:"2d-array"}),d=this.#n(this.traceGroup,[this.settings,s.params,h,f,v,this.alias,this.sky.createView(),m,u,t.films[c].buffer]),g=this.device.createCommandEncoder(),w=g.beginComputePass();return w.setPipeline(s.trace),w.setBindGroup(0,d),s.tableGroup&&w.setBindGroup(1,s.tableGroup),w.dispatchWorkgroups(Math.ceil(r/8),Math.ceil((o-n)/8)),w.end(),this.device.queue.submit([g.finish()]),this.device.queue.onSubmittedWorkDone()}#o(){return this.empty??=this.#t(new Float32Array(4))}swap(t){t.front=1-t.front,Object.assign(t,{width:t.films[t.front].width,height:t.films[t.front].height})}show(t,s,i){let a=r=>r?.films[r.front]?.buffer;if(!a(t))return;this.device.queue.writeBuffer(this.screen,0,i);let n=this.device.createCommandEncoder(),o=n.beginRenderPass({colorAttachments:[{view:this.context.getCurrentTexture().createView(),loadOp:"clear",storeOp:"store"}]});o.setPipeline(this.display),o.setBindGroup(0,this.#n(this.display.getBindGroupLayout(0),[this.screen,a(t),a(s)??a(t)])),o.draw(3),o.end(),this.device.queue.submit([n.finish()])}async#h(t,s){let i=this.device.createBuffer({size:s,usage:GPUBufferUsage.COPY_DST|GPUBufferUsage.MAP_READ}),a=this.device.createCommandEncoder();a.copyBufferToBuffer(t,0,i,0,s),this.device.queue.submit([a.finish()]),await i.mapAsync(GPUMapMode.READ);let n=new Float32Array(i.getMappedRange().slice(0));return i.destroy(),n}readFilm(t){let s=t.films[t.front];return this.#h(s.buffer,16*s.width*s.height)}async#r(t,{params:s,tableGroup:i},a,n,o,r){this.device.queue.writeBuffer(s,0,a);let l=this.#t(n),c=this.device.createBuffer({size:16*r,usage:GPUBufferUsage.STORAGE|GPUBufferUsage.COPY_SRC}),u=this.device.createCommandEncoder(),h=u.beginComputePass();h.setPipeline(t),h.setBindGroup(0,this.#n(this.numberGroup,[s,l,c])),i&&h.setBindGroup(1,i),h.dispatchWorkgroups(Math.ceil(o/64)),h.end(),this.device.queue.submit([u.finish()]);let f=await this.#h(c,16*r);return l.destroy(),c.destroy(),f}async rows(t,s,i){await this.#e(t);let a=i.length/12;return this.#r(t.rows,t,s,i,a,2*a)}async albedo(t,s,i){return t.albedo??=await(t.albedoComing??=this.#a(t,Ne)),this.#r(t.albedo,t,s,i,i.length/4,i.length/4)}};var Xs={A:0,B:1,wipe:2,side:3,diff:4},Js={none:0,reinhard:1,filmic:2};function qe({canvas:e,mode:t,wipe:s,exposure:i,tone:a,a:n,b:o}){let r=new Float32Array(16);return r.set([Xs[t],s,n.width,n.height],0),r.set([2**i,Js[a],o.width,o.height],4),r.set([1/n.samples,1/o.samples,0,0],8),r.set([e.width,e.height,0,0],12),r}function Ve(e){let t=e.reduce((m,d)=>m+d.faces.length/3,0),s=new Float32Array(3*t),i=new Float32Array(3*t),a=new Float32Array(3*t),n=new Float32Array(12*Math.max(t,1)),o=new Float32Array(20*Math.max(t,1)),r=new Uint32Array(t),l=[],c=0;for(let m of e)for(let d=0;d<m.faces.length;d+=3,c++){r[c]=c,l.push([m,d]);for(let g=0;g<3;g++){let[w,$,b]=[0,1,2].map(x=>m.positions[3*m.faces[d+x]+g]);s[3*c+g]=Math.min(w,$,b),i[3*c+g]=Math.max(w,$,b),a[3*c+g]=(s[3*c+g]+i[3*c+g])/2}}let u=[],h=(m,d)=>{let g=[1/0,1/0,1/0,-1/0,-1/0,-1/0];for(let w=m;w<d;w++)Ye(g,s,i,r[w]);return g},f=(m,d,g,w)=>{let $=h(d,g);if(u[m]=[$,d,g-d],g-d<=4||w>=36)return;let b=Ks(s,i,a,r,d,g),x=d;if(b){for(let M=d;M<g;M++)if(a[3*r[M]+b.axis]<b.at){let y=r[M];r[M]=r[x],r[x++]=y}}if(x===d||x===g){if(g-d<=16)return;x=d+g>>1}let k=u.length;u.push(null,null),u[m]=[$,k,0],f(k,d,x,w+1),f(k+1,x,g,w+1)};t&&(u.push(null),f(0,0,t,0));let v=new Float32Array(8*Math.max(u.length,1));u.forEach(([m,d,g],w)=>v.set([m[0],m[1],m[2],d,m[3],m[4],m[5],g],8*w));for(let m=0;m<t;m++)Zs(n,o,m,...l[r[m]]);return{nodes:v,places:n,looks:o,count:u.length,triangles:t}}function Ye(e,t,s,i){for(let a=0;a<3;a++)e[a]=Math.min(e[a],t[3*i+a]),e[3+a]=Math.max(e[3+a],s[3*i+a])}var He=e=>{let[t,s,i]=[e[3]-e[0],e[4]-e[1],e[5]-e[2]];return t<0?0:t*s+s*i+i*t},re=()=>[1/0,1/0,1/0,-1/0,-1/0,-1/0];function Ks(e,t,s,i,a,n){let o=null,r=1/0;for(let l=0;l<3;l++){let c=1/0,u=-1/0;for(let d=a;d<n;d++){let g=s[3*i[d]+l];c=Math.min(c,g),u=Math.max(u,g)}if(!(u>c))continue;let h=Array.from({length:16},()=>({box:re(),count:0}));for(let d=a;d<n;d++){let g=h[Math.min(15,Math.floor((s[3*i[d]+l]-c)/(u-c)*16))];Ye(g.box,e,t,i[d]),g.count++}let f=[],v=re(),m=0;for(let d=15;d>0;d--)We(v,h[d].box),m+=h[d].count,f[d]=He(v)*m;v=re(),m=0;for(let d=1;d<16;d++){We(v,h[d-1].box),m+=h[d-1].count;let g=He(v)*m+f[d];g<r&&(r=g,o={axis:l,at:c+(u-c)*d/16})}}return o}function We(e,t){for(let s=0;s<3;s++)e[s]=Math.min(e[s],t[s]),e[3+s]=Math.max(e[3+s],t[3+s])}function Zs(e,t,s,i,a){let n=[0,1,2].map(u=>i.faces[a+u]),o=u=>[0,1,2].map(h=>i.positions[3*n[u]+h]),[r,l,c]=[o(0),o(1),o(2)];e.set([...r,i.kind,l[0]-r[0],l[1]-r[1],l[2]-r[2],0,c[0]-r[0],c[1]-r[1],c[2]-r[2],0],12*s);for(let u=0;u<3;u++){let h=i.growth?i.growth[n[u]]:.5;t.set([i.normals[3*n[u]],i.normals[3*n[u]+1],i.normals[3*n[u]+2],h],20*s+4*u),i.uvs&&t.set([i.uvs[2*n[u]],i.uvs[2*n[u]+1]],20*s+12+2*u)}}function Xe({nodes:e,places:t,count:s},i,a){if(!s)return null;let n=null,o=1/0,r=a.map(c=>1/(Math.abs(c)<1e-12?1e-12:c)),l=[0];for(;l.length;){let c=8*l.pop(),u=0,h=o;for(let m=0;m<3;m++){let d=(e[c+m]-i[m])*r[m],g=(e[c+4+m]-i[m])*r[m];u=Math.max(u,Math.min(d,g)),h=Math.min(h,Math.max(d,g))}if(u>h*(1+1e-6))continue;let f=e[c+3],v=e[c+7];if(!v){l.push(f,f+1);continue}for(let m=f;m<f+v;m++){let d=12*m,[g,w]=[[t[d+4],t[d+5],t[d+6]],[t[d+8],t[d+9],t[d+10]]],$=H(a,w),b=O(g,$);if(Math.abs(b)<1e-14)continue;let x=[i[0]-t[d],i[1]-t[d+1],i[2]-t[d+2]],k=O(x,$)/b,M=H(x,g),y=O(a,M)/b,_=O(w,M)/b;k>=0&&y>=0&&k+y<=1&&_>1e-4&&_<o&&(o=_,n={t:_,i:m,u:k,v:y})}}return n}var O=(e,t)=>e[0]*t[0]+e[1]*t[1]+e[2]*t[2],H=(e,t)=>[e[1]*t[2]-e[2]*t[1],e[2]*t[0]-e[0]*t[2],e[0]*t[1]-e[1]*t[0]],T=(e,t)=>e.map(s=>s*t),R=(e,t)=>e.map((s,i)=>s+t[i]),D=e=>T(e,1/Math.hypot(...e));var Qs=20;function Je({azimuth:e,elevation:t,distance:s,target:i},a,n){let o=e*Math.PI/180,r=t*Math.PI/180,l=[Math.cos(r)*Math.sin(o),Math.sin(r),Math.cos(r)*Math.cos(o)],c=R(i,T(l,s)),u=T(l,-1),h=D(H(u,[0,1,0])),f=H(h,u),v=Math.tan(Qs*Math.PI/360)/Math.min(1,a/n);return{origin:c,forward:u,right:h,up:f,half:v,aspect:a/n}}function Ke({origin:e,forward:t,right:s,up:i,half:a,aspect:n},o,r){let l=T(s,(2*o-1)*n*a),c=T(i,(1-2*r)*a);return{o:e,d:D(R(t,R(l,c)))}}var Et=(e,t)=>.2126*e[4*t]+.7152*e[4*t+1]+.0722*e[4*t+2];function Ze(e,t,s){let i=t*s,a=new Float64Array(i),n=0;for(let f=0;f<s;f++){let v=Math.sin((f+.5)/s*Math.PI);for(let m=0;m<t;m++){let d=0;for(let g=-1;g<=1;g++)for(let w=-1;w<=1;w++)d=Math.max(d,Et(e,Math.min(s-1,Math.max(0,f+g))*t+(m+w+t)%t));n+=a[f*t+m]=(.5*d+.5*Et(e,f*t+m))*v}}let o=new Float32Array(4*i);if(!(n>0))return o;let r=a.map(f=>f*i/n),l=[],c=[],u=new Float64Array(i).fill(1),h=new Uint32Array(i);for(let f=0;f<i;f++)(r[f]<1?l:c).push(f);for(;l.length&&c.length;){let f=l.pop(),v=c[c.length-1];u[f]=r[f],h[f]=v,r[v]+=r[f]-1,r[v]<1&&l.push(c.pop())}for(let f=0;f<i;f++){let v=Math.sin((Math.floor(f/t)+.5)/s*Math.PI);o.set([u[f],h[f],a[f]/n*i/(2*Math.PI*Math.PI*v),0],4*f)}return o}function Qe(e,t,s){let i=0;for(let o=0;o<t*s;o++)Et(e,o)>Et(e,i)&&(i=o);let a=(Math.floor(i/t)+.5)/s*Math.PI,n=(i%t+.5)/t*2*Math.PI;return[-Math.sin(a)*Math.sin(n),Math.cos(a),Math.sin(a)*Math.cos(n)]}function ts({pixels:e,width:t,height:s},i,{band:a,reach:n,albedo:o}){let r=[0,0,0],l=[0,0,0];for(let m=0;m<s;m++){let d=(m+.5)/s*Math.PI,g=Math.cos(d)*Math.sin(d)*(Math.PI/s)*(2*Math.PI/t);if(g>0)for(let w=0;w<t;w++)for(let $=0;$<3;$++)r[$]+=e[4*(m*t+w)+$]*g}let[c,u]=a.map(m=>Math.floor(s*(90+m)/180)),h=t/2+i/360*t,f=t*n/360,v=0;for(let m=c;m<Math.max(u,c+1);m++)for(let d=Math.floor(h-f);d<=Math.floor(h+f);d++,v++)for(let g=0;g<3;g++)l[g]+=e[4*(m*t+(d%t+t)%t)+g];return l.map((m,d)=>Math.min(o[1],Math.max(o[0],Math.PI*m/v/Math.max(r[d],1e-12))))}var es=220,ti=12,ei=90,si=8,ii=1.14;async function Bt(e,t=""){let s="";if(t!=="webgl2")try{return{gpu:await Tt.create(),reason:s}}catch(a){s=a.message}let{create:i}=await e.part("webgl2");return{gpu:i({display:ft,members:J,modelAt:ae,rows:dt,sources:pt,tableRows:Ut,trace:mt}),reason:s}}function le(e,t){let s=L(e.positions,Uint16Array),i=L(e.normals,Int16Array),a=L(e.uvs,Int16Array);return{kind:t,faces:L(e.faces,Uint16Array),positions:Float32Array.from(s,(n,o)=>e.low[o%3]+n/65535*(e.high[o%3]-e.low[o%3])),normals:Float32Array.from(i,n=>n/32767),uvs:Float32Array.from(a,n=>n/32767*e.uv_reach),growth:e.growth?Float32Array.from(L(e.growth,Uint8Array),n=>n/255):null}}var Ot=class{constructor(t,s,i){this.gpu=t,this.start=s,this.changed=i,this.sides=[],this.limit=256,this.size=[300,200],this.ms=0,this.epoch=0,this.movedAt=-1/0,this.held=0,this.own=null,this.sky=null,this.scenes=new Map,this.rate=400,this.settings=null}replace(t){this.gpu=t,this.sceneName=this.skyName="";for(let s of this.sides)s.film=null,s.program=null,s.samples=0}light(t){if(t.env==="own"&&this.sky){let{fade:i}=this.start,a=t.turn-t.az;return this.sky.groundFor!==a&&Object.assign(this.sky,{groundFor:a,ground:ts(this.sky,a,i)}),{lamps:[],surround:[0,0,0],picture:this.sky,ground:null,fade:i.radii,groundColour:this.sky.ground,turn:t.turn}}let s=this.start.environments[t.env]??this.start.environments.studio;return{...s,fade:s.groundColour?this.start.fade.radii:[0,0],turn:t.turn}}#t(t,s){let i=t.furnace,a=t.shape==="own"&&!this.own?"ball":t.shape,n=`${a}/${i?"none":s.ground}/${this.own?.id}`;if(!this.scenes.has(n)){let{shapes:r}=this.start,l=[],c=null;a==="ball"?(l.push(le(r.shell,0)),c=r.core,i||l.push(le(r.pedestal,2))):a==="sphere"?c={centre:[0,i?1.2:1,0],radius:1}:l.push(this.own.mesh),!i&&s.ground&&l.push(le(r.grounds[s.ground],1)),this.scenes.size>6&&this.scenes.clear(),this.scenes.set(n,{...Ve(l),core:c,name:n})}let o=this.scenes.get(n);return this.sceneName!==n&&(this.gpu.setScene(o),this.sceneName=n),o}prepare(t){let s=this.light(t);this.#t(t,s),this.#s(s)}#s(t){if(!t.picture)return null;if(!t.picture.pixels){let{width:s,height:i,half:a}=t.picture,n=zt(L(a,Uint16Array)),o=new Float32Array(4*s*i);for(let r=0;r<s*i;r++)o.set(n.subarray(3*r,3*r+3),4*r);t.picture.pixels=o}return t.picture.alias??=Ze(t.picture.pixels,t.picture.width,t.picture.height),t.picture.id??=crypto.randomUUID?.()??String(Math.random()),this.skyName!==t.picture.id&&(this.gpu.setSky(t.picture),this.skyName=t.picture.id),t.picture}lightDirection(t,s){let i=this.light(t);if(i.lamps.length){let a=o=>o.radiance[1]*o.area/Math.hypot(...o.centre)**2,n=i.lamps.reduce((o,r)=>a(r)>a(o)?r:o);return Mt(n.centre,t.turn).map((o,r)=>o-s[r])}return i.picture?(this.#s(i),Mt(Qe(i.picture.pixels,i.picture.width,i.picture.height),t.turn)):[.4,1,.5]}target(t){return t.shape==="sphere"?[0,t.furnace?1.2:1,0]:t.shape==="own"&&this.own?[0,this.own.height/2,0]:[0,t.furnace?1.2:ii,0]}view(t,s,i){return Je({azimuth:t.az,elevation:t.el,distance:t.dist,target:this.target(t)},s,i)}pictureSize(t=this.settings){let[s,i]=this.size;return t.cmp==="side"&&this.sides.length>1?[Math.floor(s/2),i]:[s,i]}restart(t,{moving:s=!0}={}){this.settings=t,this.epoch++,this.movedAt=s?performance.now():-1/0,this.#e?.()}async hold(t){this.held++;try{return await t}finally{this.held--,this.#e?.()}}refresh(t){this.settings=t,this.show(),this.#e?.()}#e=null;visible(){let{cmp:t}=this.settings,s=this.sides.filter(i=>i.program);return t==="A"||this.sides.length<2?s.slice(0,1):t==="B"?s.slice(1):s}show(){let[t,s]=this.sides,i=this.settings;if(!i)return;let a=u=>!!u?.film?.width;if((!s||i.cmp==="A"?[t]:i.cmp==="B"?[s]:[t,s]).some(u=>!a(u)&&!u.error))return;let o=a(t)?t:s;if(!a(o))return;let r=a(s)?s:o,l=u=>({width:u.film.width,height:u.film.height,samples:Math.max(1,u.shown)}),c=this.sides.length<2?"A":i.cmp==="flick"?this.flicker?"B":"A":i.cmp;this.gpu.show(o.film,r.film,qe({canvas:this.gpu.canvas,mode:c,wipe:i.wipe,exposure:i.ev,tone:i.tone,a:l(o),b:l(r)}))}async run(){for(;!this.closed;){let t=performance.now(),s=!!this.settings&&t-this.movedAt<es,i=this.settings?this.visible():[],a=s?this.#a(i.length):1,n=i.filter(c=>c.epoch!==this.epoch||c.scale!==a||c.samples<(s?4:this.limit));if(!n.length||this.paused||this.held&&!s){let c=s?es-(t-this.movedAt)+1:0;await new Promise(u=>{this.#e=u,(c>0||this.paused)&&setTimeout(u,this.paused?200:c)});continue}let o=Math.min(...n.map(c=>c.epoch===this.epoch&&c.scale===a?c.samples:0)),r=n.filter(c=>c.epoch!==this.epoch||c.scale!==a||c.samples===o),l=[];try{for(let c of r){let u=await this.#i(c,a,s);if(!u)break;l.push(u)}l.length===r.length&&this.#n(l)}catch(c){this.closed||this.failed?.(c),await new Promise(u=>setTimeout(u,500))}}}#a(t){let[s,i]=this.pictureSize(),a=this.coarse??4,n=Math.sqrt(s*i*t/(this.rate*ei));return this.coarse=Math.min(si,Math.max(2,n>a*1.3||n<a*.6?Math.ceil(n):a)),this.coarse}async#i(t,s,i){let{epoch:a,settings:n}=this,{program:o}=t,r=this.light(n),l=this.#s(r),c=this.#t(n,r),[u,h]=this.pictureSize(n).map(w=>Math.max(1,Math.floor(w/s))),f=t.epoch!==a||t.scale!==s||t.film?.wanted?.[0]!==u||t.film?.wanted?.[1]!==h;t.film??=this.gpu.makeSide(),(t.mapsOf!==t.payload||t.mapsOn!==t.film)&&(t.mapData=t.maps(),this.gpu.setMaps(t.film,t.mapData),t.mapsOf=t.payload,t.mapsOn=t.film),f&&this.gpu.resize(t.film,u,h);let v=f?0:t.samples,m=Re({width:u,height:h,sample:v,view:this.view(n,u,h),light:{...r,picture:l},furnace:n.furnace,scene:c,estimator:this.estimator??"both"}),d=t.packed(),g=0;for(let w=0;w<h;){let $=Math.max(8,Math.round(this.rate*ti/u/8)*8),b=Math.min(h,w+$),x=performance.now();await this.gpu.trace(t.film,o,d,m,w,b);let k=Math.max(performance.now()-x,.2);if(g+=k,this.rate+=.3*(Math.min(u*(b-w)/k,1e6)-this.rate),w=b,this.closed||t.program!==o||!i&&this.epoch!==a)return null}return{side:t,epoch:a,scale:s,samples:v+1,spent:g}}#n(t){for(let{side:s,epoch:i,scale:a,samples:n}of t)this.gpu.swap(s.film),Object.assign(s,{epoch:i,scale:a,samples:n,shown:n});this.begun||performance.mark("gonio-picture"),this.begun=!0,this.ms=t.reduce((s,{spent:i})=>s+i,0),this.show(),this.changed(t[0].side)}async statistics(){let t=[];for(let n of this.visible()){if(!n.film?.width||n.shown<2)return null;t.push({side:n,n:n.shown,width:n.film.width,data:await this.gpu.readFilm(n.film)})}let s=(n,o)=>.2126*n[o]+.7152*n[o+1]+.0722*n[o+2],i=t.map(({side:n,n:o,data:r})=>{let l=0,c=0;for(let h=0;h<r.length;h+=4){let f=s(r,h)/o;l+=f,c+=Math.sqrt(Math.max(0,r[h+3]/o-f*f)/o)}let u=r.length/4;return{letter:n.letter,mean:l/u,noise:c/Math.max(l,1e-9)}}),a=null;if(t.length===2&&t[0].data.length===t[1].data.length){let n=0,[o,r]=t;for(let l=0;l<o.data.length;l+=4)for(let c=0;c<3;c++)n+=(o.data[l+c]/o.n-r.data[l+c]/r.n)**2;a=Math.sqrt(n/(.75*o.data.length))}return{sides:i,rmse:a}}close(){this.closed=!0,this.#e?.(),this.gpu.close()}};function ss(e,t,s,i){let[a,n]=e.pictureSize(t),o=e.view(t,a,n),{o:r,d:l}=Ke(o,s,i),c=e.scenes.get(e.sceneName);if(!c)return null;let u=Xe(c,r,l),h=u?.t??1/0,f=!1;if(c.core){let y=c.core.centre.map((F,P)=>F-r[P]),_=O(y,l),B=R(y,T(l,-_)),E=c.core.radius**2-O(B,B);E>0&&_-Math.sqrt(E)>0&&_-Math.sqrt(E)<h&&(h=_-Math.sqrt(E),f=!0)}if(!Number.isFinite(h))return null;let v=R(r,T(l,h)),m,d,g,w=.5;if(f)m=D(R(v,T(c.core.centre,-1))),d=[-m[2],0,m[0]],g=[(Math.atan2(-m[0],-m[2])/(2*Math.PI)+1)%1,Math.acos(m[1])/Math.PI];else{let y=u.i,{places:_,looks:B}=c;if(_[12*y+3]!==0)return null;let E=[1-u.u-u.v,u.u,u.v],F=I=>E[0]*B[20*y+I]+E[1]*B[20*y+4+I]+E[2]*B[20*y+8+I];m=D([F(0),F(1),F(2)]),w=F(3);let P=[0,1,2].map(I=>[B[20*y+12+2*I],B[20*y+13+2*I]]);g=[0,1].map(I=>E[0]*P[0][I]+E[1]*P[1][I]+E[2]*P[2][I]);let N=[..._.subarray(12*y+4,12*y+7)],zs=[..._.subarray(12*y+8,12*y+11)],qt=[P[1][0]-P[0][0],P[1][1]-P[0][1]],Ht=[P[2][0]-P[0][0],P[2][1]-P[0][1]];d=T(R(T(N,Ht[1]),T(zs,-qt[1])),Math.sign(qt[0]*Ht[1]-qt[1]*Ht[0]))}O(m,l)>0&&(m=T(m,-1)),d=R(d,T(m,-O(d,m)));let $=O(d,d)>1e-16?D(d):D(H(Math.abs(m[1])>.99?[1,0,0]:[0,1,0],m)),b=H(m,$),x=y=>[O(y,$),O(y,b),O(y,m)],k=x(T(l,-1)),M=x(D(e.lightDirection(t,v)));return M[2]<=0&&(M=[-k[0],-k[1],k[2]]),{p:v,t:h,uv:g,growth:w,wi:M,wo:k}}var $t=e=>String(Number(e.toPrecision(9))),is=e=>Array.isArray(e)?e.every(t=>t===e[0])?$t(e[0]):e.map($t).join("/"):typeof e=="number"?$t(e):e,bt=class{constructor(t){this.letter=t,this.payload=null,this.values=new Map,this.samples=0,this.error="",this.busy="",this.hidden=new Set,this.active=null}take(t){this.payload=t,this.values=new Map(t.parameters.map(s=>[s.path,s.value.slice()])),this.options=new Map(t.options.map(s=>[s.path,s.value])),this.models=new Map(t.models.map(s=>[s.path,s.value]))}parameter(t){return this.payload.parameters.find(s=>s.path===t)}startOf(t,s){let i=this.payload.start[t],a=t.lastIndexOf(".");for(let o=t.slice(0,Math.max(a,0));o;o=o.slice(0,Math.max(o.lastIndexOf("."),0)))if(this.models.get(o)!==this.payload.start[o])return s;if(i===void 0)return s;let n=Array.isArray(s)?s.length:0;return n?Array.isArray(i)?i:Array(n).fill(i):i}changed(t){let s=this.parameter(t),i=s?this.startOf(t,s.default):null;return s?this.values.get(t).some((a,n)=>$t(a)!==$t(i[n])):!1}text(t={}){let s=[],i=a=>Object.keys(t).some(n=>a.startsWith(`${n}.`)&&this.models.has(n)&&t[n]!==this.models.get(n));for(let[a,n]of this.models){let o=t[a]??n,r=this.payload.models.find(l=>l.path===a);!i(a)&&o!==this.startOf(a,r.default)&&s.push(`${a}=${o}`)}for(let a of this.payload.options){let n=t[a.path]??this.options.get(a.path);!i(a.path)&&n!==this.startOf(a.path,a.default)&&s.push(`${a.path}=${n}`)}for(let a of this.payload.parameters)!i(a.path)&&this.changed(a.path)&&s.push(`${a.path}=${is(this.values.get(a.path))}`);return this.payload.name+(s.length?`:${s.join(",")}`:"")}plainText(){let{payload:t}=this;if(t.name===t.model||t.name.endsWith(".py")||t.foreign)return this.text();if(this.text()===t.name&&t.plain)return t.name;let s=t.models.filter(i=>this.models.get(i.path)!==i.default).map(i=>`${i.path}=${this.models.get(i.path)}`);for(let i of t.options)this.options.get(i.path)!==i.default&&s.push(`${i.path}=${this.options.get(i.path)}`);for(let i of t.parameters)this.values.get(i.path).some((a,n)=>a!==i.default[n])&&s.push(`${i.path}=${is(this.values.get(i.path))}`);return t.model+(s.length?`:${s.join(",")}`:"")}packed(t={}){let{payload:s,path:i,values:a}=this.active,n=new Float32Array(4*Math.max(1,s.members.length));return s.members.map(i).forEach((o,r)=>n.set(t[o]??a.get(o),4*r)),n}maps(){let{maps:t}=this.payload;if(!t)return{size:1,layers:1,pixels:new Float32Array(4)};let s=zt(L(t.half,Uint16Array)),i=s.length/t.channels,a=new Float32Array(4*i);for(let n=0;n<i;n++)for(let o=0;o<t.channels;o++)a[4*n+o]=s[t.channels*n+o];return{size:t.size,layers:t.layers,pixels:a}}overrides(t,s,i,a){let n={};for(let o of this.payload.hooks)if(o.source==="mesh")n[o.path]=[s];else if(o.source==="viewer")n[o.path]=[i/o.unit];else if(o.source!=="normal_map"){let r=o.source==="flakes"?[o.tiles,o.tiles]:o.scale,{size:l,pixels:c}=a,u=t.map((w,$)=>w*r[$]*l-(o.source==="flakes"?0:.5)),h=(w,$,b)=>c[4*((o.layer*l+($%l+l)%l)*l+(w%l+l)%l)+b],[f,v]=u.map(Math.floor),[m,d]=[u[0]-f,u[1]-v],g=w=>o.source==="flakes"?h(f,v,w):(1-d)*((1-m)*h(f,v,w)+m*h(f+1,v,w))+d*((1-m)*h(f,v+1,w)+m*h(f+1,v+1,w));n[o.path]=o.width===3?[g(0),g(1),g(2)]:[g(o.channel)]}return n}};var et={a:"",b:"",cmp:"A",wipe:.5,env:"studio",turn:0,ev:0,tone:"none",furnace:!1,shape:"ball",view:"picture",az:0,el:13,dist:9.6,theta:45,layer:0,probe:"",dock:"plots",edit:"A"},ai={cmp:["A","B","wipe","side","flick","diff"],tone:["none","reinhard","filmic"],shape:["ball","sphere"],view:["picture","lobe","slices","map","albedo","weights"],dock:["plots","code","about"]},ni={wipe:[0,1],turn:[-180,180],ev:[-20,20],az:[-180,180],el:[-85,85],dist:[2.5,40],theta:[0,89],layer:[0,99]},as=e=>typeof et[e]=="number";function Nt(e){let t=[];for(let[s,i]of Object.entries(et)){let a=e[s];if(a===i&&!(s==="cmp"&&e.b)||s==="edit"||a==="own")continue;let n=as(s)?String(Math.round(a*1e4)/1e4):a===!0?"1":a;t.push(`${s}=${encodeURIComponent(String(n).toWellFormed?.()??n).replace(/%3A/g,":").replace(/%3D/g,"=").replace(/%2C/g,",").replace(/%2F/g,"/")}`)}return t.join("&")}function It(e){let t={},s=[];for(let i of e.replace(/^#/,"").split("&").filter(Boolean)){let a=i.indexOf("="),n=a<0?i:i.slice(0,a),o="";try{o=decodeURIComponent(a<0?"":i.slice(a+1))}catch{s.push(n);continue}if(n!=="token"){if(!Object.hasOwn(et,n)){s.push(n);continue}if(as(n)){if(o.trim()===""||!Number.isFinite(Number(o))){s.push(n);continue}o=Number(o)}else typeof et[n]=="boolean"&&(o=o==="1");t[n]=o}}return{state:t,bad:s}}var Ct=class{constructor(t){this.steps=[JSON.stringify(t)],this.at=0,this.name=""}add(t,s){let i=JSON.stringify(t),a=Date.now();i!==this.steps[this.at]&&(s&&s===this.name&&a-this.when<1e3?this.steps[this.at]=i:(this.steps.splice(++this.at,1/0,i),this.steps.length>200&&(this.steps.shift(),this.at--)),this.name=s,this.when=a)}step(t){return this.can(t)?(this.at+=t,this.name="",JSON.parse(this.steps[this.at])):null}can(t){return this.at+t>=0&&this.at+t<this.steps.length}},oi=e=>{let t=e.split(",");return t.length===2&&t.every(s=>s.trim()&&s>=0&&s<=1)};function ns(e,t,s){let i={...ai,env:Object.keys(t)};for(let[a,n]of Object.entries(i))a in e&&!n.includes(e[a])&&(s.push(a),delete e[a]);e.probe&&!oi(e.probe)&&(s.push("probe"),delete e.probe);for(let[a,[n,o]]of Object.entries(ni))a in e&&!(e[a]>=n&&e[a]<=o)&&(s.push(a),delete e[a]);return e}var os=180/Math.PI;function C(e){if(e===0)return"0";let t=Math.abs(e);return t<.001||t>=1e5?e.toExponential(2).replace(/\.?0+e/,"e").replace("e+","e"):String(Number(e.toFixed(t<.1?4:t<10?3:t<100?2:1)))}var U=(e,t=4)=>Number.isFinite(e)?e.toFixed(t).replace("-","−"):"–",st=(e,t)=>e.kind==="angle"?t*os:t,ri=(e,t)=>e.kind==="angle"?t/os:t,yt=e=>e.kind==="angle"?"°":"";function Lt(e,t){let s=e.scale==="log"?Math.log(Math.max(t,e.soft_low)/e.soft_low)/Math.log(e.soft_high/e.soft_low):(t-e.soft_low)/(e.soft_high-e.soft_low);return Math.max(0,Math.min(1,s))}function Rt(e,t){if(t<=0)return e.scale==="log"?e.low:e.soft_low;if(t>=1)return e.soft_high;let s=e.scale==="log"?e.soft_low*(e.soft_high/e.soft_low)**t:e.soft_low+t*(e.soft_high-e.soft_low);return Number(s.toPrecision(4))}function ce(e){let t=s=>C(st(e,s))+yt(e);return e.high===null?`at least ${t(e.low)}`:`${t(e.low)} to ${t(e.high)}`}function rs(e,t){let s=Number(t.replace("−","-").replace(",",".").replace("°","").trim());if(t.trim()===""||!Number.isFinite(s))return{error:`${t.trim()||"Nothing"} is no number.`};let i=ri(e,s),a=1e-7*Math.max(1,Math.abs(i));return i<e.low-a||e.high!==null&&i>e.high+a?{error:`Allowed is ${ce(e)}.`}:{value:Math.max(e.low,e.high===null?i:Math.min(e.high,i))}}function ls(e){let t=[];for(let s=Math.ceil(Math.log10(e.soft_low)-1e-9);s<=Math.log10(e.soft_high)+1e-9;s++){let i=[...String(s)].map(a=>a==="-"?"⁻":"⁰¹²³⁴⁵⁶⁷⁸⁹"[a]).join("");t.push({at:Lt(e,10**s),text:s<-2||s>3?`10${i}`:String(Number((10**s).toFixed(3))).replace(/^0\./,".")})}return t}var Dt=Math.PI/180,he=["red","green","blue","luminance"],it=(e,t)=>t===3?.2126*e[0]+.7152*e[1]+.0722*e[2]:e[t],K=e=>e.map(([t,s],i)=>`${i?"L":"M"}${t.toFixed(1)} ${s.toFixed(1)}`).join(""),Ft=(e,t)=>A`<path d=${e} fill="none" stroke=${t==="A"?"var(--a)":"var(--b)"} stroke-width="1.75" stroke-linejoin="round" stroke-dasharray=${t==="A"?"none":"5 3"}></path>`,cs=e=>e>=-2&&e<=3?String(Number((10**e).toFixed(3))):`10${[...String(e)].map(t=>t==="-"?"⁻":"⁰¹²³⁴⁵⁶⁷⁸⁹"[t]).join("")}`;function jt(e,t,s,i){let{width:a=300,height:n=150}=e.sizes[t]??{};return p`<svg class="p" data-chart=${t} viewBox=${`0 0 ${a} ${n}`} role="img" aria-label=${s}>${i(a,n)}</svg>`}function ue(e,t,s,i){let a=Math.min(s/2-34,i-30),n=s/2,o=i-20,r=e.flatMap(({slice:$})=>$.map(b=>it(b.f,t)*Math.cos(b.angle*Dt))).filter($=>$>0&&Number.isFinite($)),l=Math.ceil(Math.log10(Math.max(1e-6,...r))+1e-9),c=Math.min(4,Math.max(3,l+2)),u=l-c,h=$=>$>0?Math.max(0,(Math.log10($)-u)/c)*a:0,f=($,b)=>[n+b*Math.sin($*Dt),o-b*Math.cos($*Dt)],v=Array.from({length:c},($,b)=>b+1).map($=>{let b=$/c*a;return A`<path d=${`M${n-b} ${o}A${b} ${b} 0 0 1 ${n+b} ${o}`} fill="none" stroke="var(--line)"></path>${a/c>22||$%2===c%2?A`<text x=${n+b} y=${o+14} text-anchor="middle">${cs(u+$)}</text>`:""}`}),m=[-60,-30,0,30,60].map($=>A`<path d=${K([[n,o],f($,a)])} stroke="var(--line)"></path>${$?A`<text x=${f($,a+14)[0]} y=${f($,a+14)[1]+4} text-anchor="middle">${$<0?"−":""}${Math.abs($)}°</text>`:""}`),d=e[0]?.thetaO??45,[g,w]=f(-d,a);return A`${v}${m}<path d=${`M${n-a} ${o}H${n+a}`} stroke="var(--edge)"></path>
        ${e.map(({letter:$,slice:b})=>Ft(K(b.map(x=>f(x.angle,h(it(x.f,t)*Math.cos(x.angle*Dt))))),$))}
        <path d=${K([[n,o],[g,w]])} stroke="var(--text)" stroke-width="1.25" stroke-dasharray="2 3"></path><text x=${g+16} y=${w+4} class="strong">ωo</text>`}function fe({x0:e,x1:t,y1:s,ticks:i,log:a=!1,xs:n=[0,30,60,90]},o,r){return A`${i.map(l=>A`<path d=${`M${e} ${r(l)}H${t}`} stroke=${l===1&&!a?"var(--edge)":"var(--line)"}></path><text x=${e-8} y=${r(l)+4} text-anchor="end">${a?cs(Math.round(Math.log10(l))):Number(l.toFixed(3))}</text>`)}
        ${n.map(l=>A`<text x=${o(l)} y=${s+16} text-anchor="middle">${l<0?"−":""}${Math.abs(l)}°</text>`)}`}function de(e,t,s,i,a){let[n,o,r,l]=[34,s-62,8,i-22],c=Math.max(1,...e.flatMap(w=>w.albedo.map($=>it($.value,t))).filter(Number.isFinite)),u=c<=1.02?1.1:Math.ceil(c*2+.1)/2,h=u>4?Math.ceil(u/4):u>1.6?1:.5,f=w=>n+(o-n)*w/90,v=w=>l-(l-r)*Math.min(w,u)/u,m=Array.from({length:Math.floor(u/h+1e-6)+1},(w,$)=>$*h),d=[],g=e.map(({letter:w,albedo:$})=>{let b=$.map(y=>[y.angle,it(y.value,t)]),x=b.filter(([,y])=>y>1.0005),k=b[b.length-1][1],M=v(k)+4;for(let y of d)Math.abs(y-M)<14&&(M=y+(M>=y?14:-14));return d.push(M),A`${x.length?A`<path fill="var(--warn)" opacity=".28" d=${`${K([[f(x[0][0]),v(1)],...x.map(([y,_])=>[f(y),v(_)]),[f(x[x.length-1][0]),v(1)]])}Z`}></path><text x=${Math.min(f(x[0][0])-6,o-4)} y=${Math.max(v(1)-12,r+10)} text-anchor=${f(x[0][0])>n+150?"end":"start"} class="warn">${w} gains energy ${x[0][0]>0?`from ${Math.round(x[0][0])}°`:"everywhere"}</text>`:""}
            ${Ft(K(b.map(([y,_])=>[f(y),v(_)])),w)}<text x=${o+8} y=${M} class=${`of${w}`}>${w} ${U(k,2)}</text>`});return A`${fe({x0:n,x1:o,y0:r,y1:l,ticks:m},f,v)}${g}
        ${a===null?"":A`<path d=${`M${f(a)} ${r}V${l}`} stroke="var(--text)" stroke-dasharray="2 3"></path><text x=${f(a)+(a>55?-6:6)} text-anchor=${a>55?"end":"start"} y=${r+10} class="strong">θo ${Math.round(a)}°</text>`}`}function hs(e,t){e.width=e.height=G;let s=e.getContext("2d"),i=s.createImageData(G,G),a=t.filter(Boolean).map(o=>Math.max(...o)).filter(Number.isFinite).sort((o,r)=>o-r),n=Math.max(1e-9,a[Math.floor(.95*a.length)]??1);t.forEach((o,r)=>i.data.set(o?[...o.map(l=>Math.round(255*vt(Math.min(1,Math.max(0,l/n))))),255]:[0,0,0,0],4*r)),s.putImageData(i,0,0)}var li={reset:"M3.5 8a4.5 4.5 0 1 0 1.6-3.4M3.5 2.5v3h3",undo:"M3 6h6.5a3.5 3.5 0 0 1 0 7H6M3 6l3-3M3 6l3 3",redo:"M13 6H6.5a3.5 3.5 0 0 0 0 7H10M13 6l-3-3M13 6l-3 3",swap:"M3 5h10l-2.5-2.5M13 11H3l2.5 2.5",light:"M8 5a3 3 0 1 0 0 6 3 3 0 0 0 0-6zM8 1v1.5M8 13.5V15M1 8h1.5M13.5 8H15M3 3l1 1M12 12l1 1M13 3l-1 1M4 12l-1 1",large:"M9.5 2.5h4v4M6.5 13.5h-4v-4M13.5 2.5L9 7M2.5 13.5L7 9",eye:"M1.5 8s2.4-4.5 6.5-4.5S14.5 8 14.5 8 12.1 12.5 8 12.5 1.5 8 1.5 8zM8 6.2a1.8 1.8 0 1 0 0 3.6 1.8 1.8 0 0 0 0-3.6z",closed:"M1.5 6.5S4 10.5 8 10.5s6.5-4 6.5-4M3.6 9.2L2.3 11M12.4 9.2l1.3 1.8M8 10.5v2.2",warn:"M8 2.2L14.5 13.5h-13zM8 6.5v3.2M8 11.6v.01",info:"M8 2a6 6 0 1 0 0 12A6 6 0 0 0 8 2zM8 7.3v3.4M8 5.2v.01",layers:"M8 2l6 3.2-6 3.2-6-3.2zM2 8.2l6 3.2 6-3.2M2 11l6 3.2 6-3.2",plots:"M2 2v12h12M4.5 10.5l3-4 2.5 2 3.5-5",code:"M5.5 4L1.5 8l4 4M10.5 4l4 4-4 4",wipe:"M5.5 4.5L2 8l3.5 3.5M10.5 4.5L14 8l-3.5 3.5",close:"M4 4l8 8M12 4l-8 8",more:"M3 8h.01M8 8h.01M13 8h.01",plus:"M8 3v10M3 8h10"},S=e=>A`<svg class="ic" viewBox="0 0 16 16" aria-hidden="true"><path d=${li[e]}></path></svg>`;function W(e){let t=[{prefix:"",model:e.payload.model,child:null}];for(let[s,i]of e.models)t[t.length-1].child=s,t.push({prefix:`${s}.`,model:i,child:null});return t.forEach((s,i)=>{s.number=i+1,s.title=ci(e,s,t.length)}),t}function ci(e,t,s){let i=e.values.get(`${t.prefix}sigma_a`),a=e.values.get(`${t.prefix}thickness`);return t.child?i?.some(n=>n>0)&&a?.[0]!==0?"Tinted coat":"Clear coat":s>1?"Base":"Surface"}var hi=["eta","top_eta","alpha","roughness","sigma","shininess","metal_alpha","metallic"];function ui(e,t){let s=t.child?[]:[t.model];for(let i of hi){let a=e.values.get(t.prefix+i);a?.length===1&&s.length<3&&s.push(`${i} ${C(a[0])}`)}return s.join(" · ")}function us(e,{prefix:t,child:s}){let i=c=>e.values.get(t+c),a=i("sigma_a"),n=i("thickness")?.[0]??1;if(s){let c=a?a.map(u=>Math.exp(-2*u*n)):[1,1,1];return c.every(u=>u>.98)?"var(--cut1)":q(c)}let o=i("rho")??i("base_color");if(o)return q(o.map(c=>Math.max(c,.02)));let r=i("metal_eta")??i("eta"),l=i("metal_k")??i("k");return r?.length===3&&l?.length===3?q(r.map((c,u)=>((c-1)**2+l[u]**2)/((c+1)**2+l[u]**2))):i("f0")?q(i("f0")):"var(--edge)"}var fs=e=>{let t=e;return()=>(t=t*16807%2147483647)/2147483647};function fi(e,t){let s=fs(t*7919+17);return Array.from({length:19},(i,a)=>`${a?"L":"M"}${4*a} ${(9+e*9*(s()-.5)).toFixed(1)}`).join("")}function di(e,t){for(let s of["alpha","roughness","sigma","metal_alpha"]){let i=e.values.get(t+s);if(i)return Math.min(1,i[0])**.6}return .35}function mi(e,t,s){let i=fi(di(e,t.prefix),t.number),a=fs(99),n=t.child?[]:Array.from({length:26},()=>A`<circle cx=${(4+64*a()).toFixed(1)} cy=${(18+28*a()).toFixed(1)} r=${(.6+.7*a()).toFixed(1)} fill="#0003"></circle>`);return p`<svg viewBox="0 0 72 50" preserveAspectRatio="none" aria-hidden="true">${A`
        <path d="M0 0H72V50H0Z" fill=${s}></path><path d=${`${i}L72 50L0 50Z`} fill=${us(e,t)}></path>${n}
        <path d=${i} fill="none" stroke="#fff9" stroke-width="1.25"></path>`}</svg>`}function ds(e){let t=e.edited(),s=W(t),i="var(--air)",a=s.map((n,o)=>{let r=o===e.layerIndex(),l=t.hidden.has(n.prefix),c=mi(t,n,i);return i=us(t,n),p`<div class="lay ${l?"off":""} ${s.length>5&&!r?"thin":""}" ?data-on=${r}>${c}
            <button role="tab" aria-selected=${r} @click=${()=>e.set({layer:o})}><b>${n.number}&ensp;${n.title}</b><small>${ui(t,n)}</small></button>
            ${n.child?p`<button class="ib" aria-pressed=${l} aria-label=${`${l?"Show":"Hide"} layer ${n.number}`} title=${l?"Show":"Hide: see what is below"} @click=${()=>e.hide(n.prefix)}>${S(l?"closed":"eye")}</button><button class="ib" aria-label=${`Remove layer ${n.number}`} title="Remove this coat" @click=${()=>e.do("removeLayer",n)}>${S("close")}</button>`:p`<span></span><span></span>`}</div>`});return p`<div class="sec"><div class="hd"><h2>Layers</h2>${e.two?p`<span class="xs dim">edit</span><div class="seg" role="group" aria-label="Edit">${["A","B","AB"].map(n=>p`
        <button aria-pressed=${e.state.edit===n} @click=${()=>e.set({edit:n})}>${n==="AB"?"A + B":n}</button>`)}</div>`:""}
        <span class="sp"></span><button class="btn" title="A clear coat above everything" @click=${()=>e.do("addCoat")}>+ Coat</button></div><div class="stack" role="tablist" aria-label="Layers, top first" aria-orientation="vertical">${a}</div></div>`}var pi={water:1.333,"soap film":1.4,acrylic:1.49,"clear coat":1.5,polycarbonate:1.585,sapphire:1.77,zirconia:2.16,diamond:2.417},vi={mesh:"from the mesh",viewer:"from the viewer",flakes:"from a flake map",texture:"from a texture"},ms=(e,t)=>t.startsWith(e)&&!t.slice(e.length).includes("."),me=e=>e.slice(e.lastIndexOf(".")+1),gi=e=>e?`${e[0].toUpperCase()}${e.slice(1).replaceAll("="," = ")}.`:"";function ps(e){let t=e.edited(),s=W(t),i=s[e.layerIndex()],a=t.payload.parameters.filter(l=>ms(i.prefix,l.path)),n=t.payload.options.filter(l=>ms(i.prefix,l.path)),o=new Map(t.payload.hooks.map(l=>[l.path,l])),r=l=>l.prefix?l.prefix.slice(0,-1):l.model;return p`<div role="tabpanel" aria-label=${`Layer ${i.number}`}>
        ${t.error?p`<div class="sec"><div class="note" role="alert">${S("warn")}<div><b>${t.error.title}</b><p>${t.error.text}</p></div></div></div>`:""}
        <div class="sec"><div class="hd"><h2>${s.length>1?p`${i.number}&ensp;`:""}${i.title}</h2><span class="sp"></span><div class="pick">${wi(e,t,i)}</div><button class="ib" aria-label="Reset layer" title="Reset layer" @click=${()=>e.do("resetLayer",i)}>${S("reset")}</button></div>
            ${s.length>1?p`<div class="path">${s.map((l,c)=>p`${c?" › ":""}${l===i?p`<b>${r(l)}</b>`:r(l)}`)}</div>`:""}
            ${i.prefix?"":p`<p class="hint about1">${t.payload.description}</p>`}
            ${a.map(l=>bi(e,t,i,l,o.get(l.path)))}</div>
        ${n.length?p`<div class="sec"><div class="hd"><h2>Options</h2><span class="dim xs">${t.busy||"recompile in under 0.5 s"}</span><span class="sp"></span>
            ${n.some(l=>e.differs(l.path))?p`<span class="xs dim"><i class="diffdot"></i>&ensp;differs in ${t.letter==="A"?"B":"A"}</span>`:""}</div>
            ${n.map(l=>Si(e,t,l))}</div>`:""}</div>`}function wi(e,t,s){let i=e.start.catalogue.filter(o=>o.kind==="model"||!s.prefix),a=s.prefix?s.model:t.payload.name,n=(o,r)=>p`<optgroup label=${r}>${i.filter(l=>l.kind===o).map(l=>p`<option value=${l.name} ?selected=${l.name===a}>${l.name}</option>`)}</optgroup>`;return p`<select aria-label="Model of this layer" .value=${a} @change=${o=>e.chooseModel(s,o.target.value)}>
        ${i.some(o=>o.kind==="file")?n("file","Your files"):""}${n("model","Models")}${s.prefix?"":n("material","Materials")}</select>`}function $i(e,t,s){return e.used?s?vi[s.source]:e.kind==="index"&&e.width===1&&e.path.includes(".")?`over layer ${t.number-1}`:e.kind==="slope"&&e.scale==="log"?"log scale":["factor","number","length"].includes(e.kind)?"":e.kind:"unused"}function bi(e,t,s,i,a){let n=me(i.path),o=t.values.get(i.path),r=!i.used||!!a,l=$i(i,s,a),c=t.changed(i.path)&&!r?p`<button class="rs" aria-label=${`Reset ${i.path}`} title="Reset" @click=${()=>e.resetParameter(i.path)}>${S("reset")}</button>`:p`<span></span>`,u=p`<label title=${`${i.doc}; ${ce(i)}`} @dblclick=${()=>e.resetParameter(i.path)}>${n}${l?p`<small>${l}</small>`:""}</label>`,h=(d,g="hint")=>p`<span></span><div class="wide ${g}">${d}</div><span></span>`,f=e.fieldError?.path===i.path?p`<span></span><div class="wide err" role="alert">${e.fieldError.text} The picture still shows ${o.map(d=>`${C(st(i,d))}${yt(i)}`).join(", ")}.</div><span></span>`:"",v=i.unused_because?h(gi(i.unused_because)):"";if(i.width===1){let d=o[0],g=t.values.get(`${s.prefix}sigma_a`),w=n==="thickness"&&g?.some($=>$>0);return p`<div class="prm ${r?"offp":""}" title=${i.doc}>${u}${yi(e,i,d,r,w?xi(g,i):"")}${pe(e,i,d,r,0)}${c}
            ${f}${i.scale==="log"&&!w&&!r?p`<span></span><div class="tick">${ls(i).map($=>p`<span .style=${`left:${100*$.at}%`}>${$.text}</span>`)}</div><span></span><span></span>`:""}
            ${i.kind==="index"&&!r?h(Mi(e,t,s,i,d),""):""}${i.kind==="angle"&&!r?h(`${C(d)} rad in code and links.`):""}
            ${w?h("Track: white light after down and up, seen from above."):""}${v}</div>`}if(i.kind==="reflectance"&&!r)return Ai(e,i,o,u,c,f);let m=!r&&i.kind==="index"&&t.parameter(i.path.replace(/eta$/,"k"));return p`<div class="prm ${r?"offp":""}" title=${i.doc}>${u}${m?p`<div class="wide">${_i(e,t,i)}</div>${c}<span></span>`:""}
        <div class="tri wide">${[0,1,2].map(d=>p`<span data-c=${"RGB"[d]}>${pe(e,i,o[d],r,d)}</span>`)}</div>${m?p`<span></span>`:c}${f}${v}</div>`}function yi(e,t,s,i,a){let n=Lt(t,s),o=l=>e.setParameter(t.path,[l]),r=l=>{let c={ArrowRight:1,ArrowUp:1,ArrowLeft:-1,ArrowDown:-1}[l.key];if(!c)return;l.preventDefault();let u=Lt(t,e.edited().values.get(t.path)[0]);o(Rt(t,Math.min(1,Math.max(0,u+c*(l.shiftKey?.1:.01)))))};return p`<input type="range" class=${a?"beer":""} aria-label=${t.path} aria-valuetext=${`${C(st(t,s))}${yt(t)}`} min="0" max="1000" step="1" ?disabled=${i}
        .value=${String(Math.round(1e3*n))} .style=${`--f:${100*n}%;${a?`--g:${a}`:""}`} @input=${l=>o(Rt(t,l.target.valueAsNumber/1e3))} @keydown=${r}>`}function xi(e,t){return`linear-gradient(90deg,${Array.from({length:9},(i,a)=>q(e.map(n=>Math.exp(-2*n*Rt(t,a/8))))).join(",")})`}function pe(e,t,s,i,a){let n=t.width===1?`${t.path}, value`:`${t.path} ${"RGB"[a]}`,o=`${C(st(t,s))}${yt(t)}`,r=e.fieldError?.path===t.path&&e.fieldError.channel===a?e.fieldError:null,l=u=>{if(u.target.value===o)return;let h=rs(t,u.target.value);if(h.error){e.fail({path:t.path,channel:a,text:h.error,typed:u.target.value});return}let f=e.edited().values.get(t.path).slice();f[a]=h.value,e.setParameter(t.path,f)},c=u=>{u.stopPropagation(),u.key==="Enter"&&l(u),u.key==="Escape"&&(u.target.value=o,e.fail(null),u.target.blur())};return p`<input class="n ${r?"bad":""}" inputmode="decimal" spellcheck="false" autocomplete="off" aria-label=${n} aria-invalid=${r?"true":"false"} ?disabled=${i}
        .value=${r?r.typed:o} title=${String(st(t,s))} @change=${l} @focus=${u=>u.target.select()} @keydown=${c}>`}var ki=(e,t)=>W(e).slice(0,t.number-1).reduce((s,i)=>s*(e.values.get(`${i.prefix}eta`)?.[0]??1),1);function Mi(e,t,s,i,a){let n=i.path.includes(".")?ki(t,s):1,o=Object.entries(pi).map(([l,c])=>[l,c/n]).filter(([,l])=>l>=i.low&&(i.high===null||l<=i.high)),r=o.find(([,l])=>Math.abs(l-a)<5e-4)?.[0]??"";return p`<select aria-label=${`Named index of ${i.path}`} .value=${r} @change=${l=>l.target.value&&e.setParameter(i.path,[o.find(([c])=>c===l.target.value)[1]])}><option value="" ?selected=${!r}>custom${n!==1?`: ${C(a)} over layer ${s.number-1} (${C(a*n)} in air)`:`, ${U(a,3)}`}</option>
        ${o.map(([l,c])=>p`<option value=${l} ?selected=${l===r}>${l}, ${U(c*n,3)}${n!==1?` (${U(c,3)} here)`:""}</option>`)}</select>`}function _i(e,t,s){let i=s.path.replace(/eta$/,"k"),a=t.parameter(i),n=t.values.get(s.path),o=t.values.get(i),r=(h,f)=>f.every(v=>v>=h.low&&v<=(h.high??1/0)),l=(h,f)=>h.every((v,m)=>Math.abs(v-f[m])<1e-4),c=Object.entries(e.start.metals).filter(([,h])=>r(s,h.eta)&&r(a,h.k)),u=c.find(([,h])=>l(h.eta,n)&&l(h.k,o))?.[0]??"";return p`<select aria-label=${`Named metal of ${s.path}`} .value=${u} @change=${h=>{let f=e.start.metals[h.target.value];f&&e.setParameters({[s.path]:f.eta,[i]:f.k})}}><option value="" ?selected=${!u}>custom</option>${c.map(([h,f])=>p`<option value=${h} ?selected=${h===u}>${h}, ${f.eta.map(C).join(" ")}</option>`)}</select>`}var xt=e=>Math.min(1,Math.max(0,e));function Ai(e,t,s,i,a,n){let o=e.hue?.path===t.path&&gt(oe(e.hue.hsv))===gt(s),[r,l,c]=o?e.hue.hsv:Fe(s),u=e.openColours.has(t.path),h=d=>{e.hue={path:t.path,hsv:d},e.setParameter(t.path,oe(d).map(g=>Number(xt(g).toPrecision(5))))},f=(d,g)=>{let w=d.currentTarget,$=w.getBoundingClientRect(),b=x=>g(xt((x.clientX-$.left)/$.width),xt((x.clientY-$.top)/$.height));w.setPointerCapture(d.pointerId),w.onpointermove=b,w.onpointerup=()=>{w.onpointermove=null},b(d)},v=(d,g)=>{let w={ArrowRight:[1,0],ArrowLeft:[-1,0],ArrowUp:[0,1],ArrowDown:[0,-1]}[d.key];w&&(d.preventDefault(),g(w[0]*(d.shiftKey?.1:.01),w[1]*(d.shiftKey?.1:.01)))},m=d=>{let g=_t(d.target.value);g?e.setParameter(t.path,g):e.fail({path:t.path,channel:-1,text:`${d.target.value} is no colour such as #EFCEAD.`})};return p`<div class="prm" title=${t.doc}>${i}<div class="wide row"><button class="swt" .style=${`background:${q(s)}`} aria-expanded=${u} aria-label=${`${u?"Close":"Open"} the colours of ${t.path}`} title="Colours" @click=${()=>e.toggleColour(t.path)}></button><input class="n m left" aria-label=${`${t.path}, sRGB`} spellcheck="false" .value=${gt(s)} @change=${m} @keydown=${d=>{d.stopPropagation(),d.key==="Enter"&&m(d)}}></div>${a}
        ${u?p`<span></span><div class="wide"><div class="sv" role="slider" tabindex="0" aria-label=${`Saturation and value of ${t.path}`} aria-valuetext=${gt(s)} .style=${`--h:${r}`} @pointerdown=${d=>f(d,(g,w)=>h([r,g,1-w]))} @keydown=${d=>v(d,(g,w)=>h([r,xt(l+g),xt(c+w)]))}><i .style=${`left:${100*l}%;top:${100*(1-c)}%`}></i></div><div class="hue" role="slider" tabindex="0" aria-label=${`Hue of ${t.path}`} aria-valuenow=${Math.round(r)} @pointerdown=${d=>f(d,g=>h([360*Math.min(g,.9999),l,c]))} @keydown=${d=>v(d,g=>h([(r+300*g+360)%360,l,c]))}><i .style=${`left:${r/3.6}%`}></i></div></div><span></span>`:""}
        <label class="c"><small>linear</small></label><div class="tri wide">${[0,1,2].map(d=>p`<span data-c=${"RGB"[d]}>${pe(e,t,s[d],!1,d)}</span>`)}</div><span></span>${n}</div>`}function Si(e,t,s){let i=me(s.path),a=t.options.get(s.path),n=t.startOf(s.path,s.default),o=s.values.filter(f=>!f.allowed),r=e.refused?.path===s.path?e.refused:null,l=f=>{let v=s.values.find(m=>m.value===f.target.value);if(v.allowed){e.setOptions({[s.path]:v.value});return}f.target.value=a,e.refuse(s.path,v)},c=s.values.filter(f=>f.allowed&&f.value!==a).map(f=>f.value),u=()=>e.do("expect",s.path,c),h=Object.entries(r?.remedy??{});return p`<div class="opt" title=${s.doc}><span class=${a!==n?"ch":""}>${i}${e.differs(s.path)?p`<i class="diffdot" role="img" aria-label="differs"></i>`:""}</span><select aria-label=${s.path} data-value=${a} @change=${l} @pointerenter=${u} @focus=${u}>${s.values.map(f=>p`<option value=${f.value} ?selected=${f.value===a}>${f.value}${f.allowed?"":" – refused"}</option>`)}</select>
        ${a!==n?p`<button class="rs" aria-label=${`Reset ${s.path}`} title="Reset" @click=${()=>e.setOptions({[s.path]:n})}>${S("reset")}</button>`:p`<span></span>`}
        ${r?p`<div class="why" role="alert"><p><b>${r.value}</b>: ${r.reason}</p><div class="row">
            ${h.length?p`<button class="btn" @click=${()=>e.setOptions({...r.remedy,[s.path]:r.value})}>Set ${h.map(([f,v])=>`${me(f)} = ${v}`).join(", ")}</button>`:""}<button class="btn" @click=${()=>e.refuse(null)}>Close</button></div></div>`:""}
        ${!r&&o.length?p`<span></span><button class="hint link" @click=${()=>e.refuse(s.path,o[0])}>${o.map(f=>f.value).join(", ")} ${o.length===1?"is":"are"} refused: why?</button><span></span>`:""}</div>`}var $s=[["A","A"],["B","B"],["wipe","Wipe"],["side","Side"],["flick","Flicker"],["diff","×10"]],Pi=[["picture","Picture"],["lobe","Lobe"],["slices","Slices"],["map","θh θd"],["albedo","Albedo"],["weights","Weights"]],bs=[["plots","Plots"],["code","Code"],["about","About"]],Ui=[["side","Layers","layers"],["light","Light","light"],["plots","Plots","plots"],["code","Code","code"],["about","About","info"]],ve=e=>e.theme??(matchMedia("(prefers-color-scheme:light)").matches?"light":"dark");function ys(e){e.options.themed?.(ve(e));let t=e.edited(),s=t.payload,i=e.phone??"side";return p`<div class="page" data-t=${ve(e)} @dragover=${a=>{a.preventDefault()}} @drop=${a=>{a.preventDefault();for(let n of[...a.dataTransfer.files].slice(0,2))e.take(n)}}><div class="app" data-c=${e.two?e.state.cmp:"A"} data-d=${e.state.dock} data-p=${["plots","code","about"].includes(i)?"dock":i}>
            ${zi(e)}${Ti(e)}${Ri(e)}${Fi(e)}
            <aside class="side" aria-label="Material">${s?p`${ds(e)}${ps(e)}`:p`<div class="sec">${t.error?p`<div class="note" role="alert">${S("warn")}<div><b>${t.error.title}</b><p>${t.error.text}</p></div></div>`:p`<p class="dim">One moment …</p>`}</div>`}</aside><nav class="ptabs" role="tablist" aria-label="Panels">${Ui.map(([a,n,o])=>p`<button role="tab" aria-selected=${i===a} @click=${()=>{e.phone=a,bs.some(([r])=>r===a)&&e.set({dock:a}),e.update()}}>${S(o)}${n}</button>`)}</nav></div>${e.help?e.more(a=>a.help(e)):""}${e.menu?e.more(a=>a.menu(e)):""}${e.picking?e.more(a=>a.picker(e)):""}</div>`}function xs(e,t){if(!t.payload)return"";let s=e.two?e.sides[t.letter==="A"?1:0]:null,i=[],a=s?.payload?.model===t.payload.model?s:null;for(let[n,o]of t.options)(a?.options?a.options.get(n)!==o:o!==t.startOf(n,o))&&i.push(o);for(let n of t.payload.parameters){let o=t.values.get(n.path),r=a?.values?.get(n.path);(a?r?.some((l,c)=>l!==o[c]):t.changed(n.path))&&i.push(`${n.path} ${o.length===1?Number(o[0].toPrecision(3)):""}`.trim())}return i.slice(0,3).join(", ")||(t.payload.title||"").split(":")[0]}function vs(e,t){return p`<button class="chip ${t.letter}" title=${`Choose model ${t.letter}`} aria-label=${`Model ${t.letter}: ${t.text?.call&&t.payload?t.payload.name:""}. Choose another`} @click=${()=>{e.picking=t.letter,e.search="",e.update()}}><b>${t.letter}</b><span>${t.payload?.name.split("/").pop()??"…"}<small>${xs(e,t)}</small></span></button>`}function zi(e){let t=e.state,s=()=>{e.theme=ve(e)==="light"?"dark":"light",e.update()};return p`<header class="top"><div class="logo">gonio <span>view</span></div>${vs(e,e.sides[0])}
        ${e.two?p`<button class="ib u" aria-label="Swap A and B" title="Swap A and B (X)" @click=${()=>e.swap()}>${S("swap")}</button>${vs(e,e.sides[1])}<button class="ib u" aria-label="Stop comparing" title="Stop comparing (C)" @click=${()=>e.compare(!1)}>${S("close")}</button>`:p`<button class="btn u" title="Compare with a copy (C)" @click=${()=>e.compare(!0)}>Compare</button>`}
        <span class="sp"></span>${e.two?p`<div class="seg" role="group" aria-label="Compare">${$s.map(([i,a])=>p`<button aria-pressed=${t.cmp===i} @click=${()=>e.set({cmp:i})}>${a}</button>`)}</div><span class="sp"></span>`:""}
        <button class="ib u" aria-label="Undo" title="Undo (Ctrl Z)" ?disabled=${!e.history?.can(-1)} @click=${()=>e.step(-1)}>${S("undo")}</button><button class="ib u" aria-label="Redo" title="Redo (Ctrl Shift Z)" ?disabled=${!e.history?.can(1)} @click=${()=>e.step(1)}>${S("redo")}</button><button class="btn t" @click=${()=>e.copy(e.link(),"The link")}>Copy link</button><button class="btn t" @click=${()=>e.savePicture()}>Save picture</button><button class="ib more" aria-label="More" title="Copy link, save picture" aria-expanded=${!!e.menu} @click=${()=>{e.menu=!e.menu,e.update()}}>${S("more")}</button><button class="ib" aria-label="Light or dark" title="Light or dark" @click=${s}>${S("light")}</button></header>`}function Ti(e){let t=e.state,s=e.two&&t.cmp==="wipe"&&t.view==="picture",i=e.two&&["wipe","side"].includes(t.cmp)&&t.view==="picture";return p`<main class="stage" aria-label="Picture" data-c=${e.two?t.cmp:"A"} .style=${`--w:${t.cmp==="side"?50:100*t.wipe}%`}><div class="canvas" tabindex="0" role="img" aria-label=${`${e.sides.map(a=>a.payload?.name).join(" and ")} under ${t.furnace?"the furnace":t.env}. Arrows turn the camera, with Shift they move the probe.`} @pointerdown=${a=>Ci(e,a)} @pointermove=${a=>Bi(e,a)} @pointerleave=${()=>{e.pointer=null}} @wheel=${a=>{a.preventDefault(),e.set({dist:Math.min(40,Math.max(2.5,t.dist*Math.exp(a.deltaY*.001)))},"dist")}} @keydown=${a=>Ni(e,a)} @dblclick=${a=>{let n=ge(e,a);n&&e.probe(...n)}}></div>
        ${t.view!=="picture"?e.more(a=>a.large(e),p`<div class="large"></div>`):""}
        ${s?p`<div class="wipe" role="slider" tabindex="0" aria-orientation="horizontal" aria-label="Wipe between A and B" aria-valuemin="0" aria-valuemax="100" aria-valuenow=${Math.round(100*t.wipe)} @pointerdown=${a=>Ii(e,a)} @keydown=${a=>{let n={ArrowLeft:-1,ArrowRight:1}[a.key];n&&(a.preventDefault(),a.stopPropagation(),e.set({wipe:Math.min(1,Math.max(0,t.wipe+n*(a.shiftKey?.1:.01)))},"wipe"))}}><i>${S("wipe")}</i></div>`:""}
        ${i?e.sides.map(a=>p`<div class="glass tag ${a.letter}"><b class="k ${a.letter==="B"?"kb":""}">${a.letter}</b><span>${xs(e,a)}</span></div>`):""}
        <div class="glass views" role="tablist" aria-label="View">${Pi.map(([a,n])=>p`<button role="tab" aria-selected=${t.view===a} @click=${()=>e.set({view:a})}>${n}</button>`)}</div>
        ${Ei(e)}${t.view==="picture"?Li(e):""}${Oi(e)}
        ${e.notes.length?p`<div class="notes" aria-live="polite">${e.notes.map(a=>p`<div class="glass note1 ${a.kind}">${S(a.kind==="warn"?"warn":"info")}<div><b>${a.title}</b>${a.text?p`<p>${a.text}</p>`:""}</div><button class="ib" aria-label="Close message" @click=${()=>e.dismiss(a)}>${S("close")}</button></div>`)}</div>`:""}
        <div class="glass keys">${e.two?p`<span><kbd>W</kbd>wipe</span>`:p`<span><kbd>C</kbd>compare</span>`}<span><kbd>F</kbd>furnace</span><button @click=${()=>{e.help=!0,e.update()}}><kbd>?</kbd>all keys</button></div></main>`}function Ei(e){let t=e.renderer?.settings?e.renderer.visible():[],s=Math.min(...t.map(n=>n.shown||0),1/0),i=e.statistics?.sides,a=i?.length?Math.max(...i.map(n=>n.noise)):null;return p`<div class="glass qual" title="Samples per pixel, noise of the mean, time per pass"><i class="h" .style=${`--q:${Number.isFinite(s)?100*s/e.renderer.limit:0}%`}></i><span><b>${Number.isFinite(s)?s:0}</b> <span class="dim">spp</span></span>
        ${a===null?"":p`<span><b>${a<.1?U(100*a,1):Math.round(100*a)} %</b> <span class="dim">noise</span></span>`}${e.renderer?p`<span class="h"><b>${e.renderer.ms<100?U(e.renderer.ms,1):Math.round(e.renderer.ms)}</b> <span class="dim">ms</span></span>`:""}<span class="dim h" title=${e.gpu?.adapter??""}>${e.gpu?.name??"no GPU"}</span></div>`}function Oi(e){let t=e.statistics;return!t||e.state.view!=="picture"?"":p`<div class="glass cmp" title="Linear values, whole picture, no tone curve">${t.rmse===null?"":p`<span><span class="dim">RMSE</span><b>${U(t.rmse)}</b></span>`}${t.sides.map(s=>p`<span class=${e.two?"h":""}><span class="dim">mean ${e.two?s.letter:""}</span><b class="thin">${U(s.mean)}</b></span>`)}</div>`}function ge(e,t){let s=t.currentTarget.getBoundingClientRect(),i=(t.clientX-s.left)/s.width,a=(t.clientY-s.top)/s.height;return e.two&&e.state.cmp==="side"&&(i=i*2%1),i>=0&&i<=1&&a>=0&&a<=1?[i,a]:null}function Bi(e,t){e.pointer=ge(e,t)}function Ci(e,t){let s=t.currentTarget,{az:i,el:a}=e.state,[n,o]=[t.clientX,t.clientY],r=ge(e,t),l=!1;s.setPointerCapture(t.pointerId);let c=h=>{if(!l&&Math.hypot(h.clientX-n,h.clientY-o)<4)return;l=!0;let f=(i-(h.clientX-n)*.4+540)%360-180;e.set({az:Math.round(f*10)/10,el:Math.round(Math.min(85,Math.max(e.state.furnace?-85:-2,a+(h.clientY-o)*.3))*10)/10},"camera")},u=()=>{s.removeEventListener("pointermove",c),s.removeEventListener("pointerup",u),!l&&r&&matchMedia("(pointer:coarse)").matches&&e.probe(...r)};s.addEventListener("pointermove",c),s.addEventListener("pointerup",u)}var we=[.5,.45],gs=e=>Math.min(1,Math.max(0,e));function Ni(e,t){let s={ArrowLeft:[-5,0],ArrowRight:[5,0],ArrowUp:[0,3],ArrowDown:[0,-3]}[t.key];if(s){if(t.preventDefault(),t.shiftKey){let[i,a]=e.state.probe?e.state.probe.split(",").map(Number):we;e.probe(gs(i+s[0]/500),gs(a-s[1]/200));return}e.set({az:(e.state.az+s[0]+540)%360-180,el:Math.min(85,Math.max(-2,e.state.el+s[1]))},"camera")}}function Ii(e,t){let s=t.currentTarget,i=s.parentNode.getBoundingClientRect();t.preventDefault(),s.setPointerCapture(t.pointerId);let a=n=>e.set({wipe:Math.round(Math.min(1,Math.max(0,(n.clientX-i.left)/i.width))*1e3)/1e3},"wipe");s.onpointermove=a,s.onpointerup=()=>{s.onpointermove=null}}var ws=e=>`${U(Math.acos(Math.max(-1,Math.min(1,e)))*180/Math.PI,1)}°`;function Li(e){let t=e.probed;if(!e.state.probe||!t)return"";let s=e.two&&e.state.cmp==="side"?t.x/2:t.x;return p`<span class="hair" aria-hidden="true" .style=${`left:${100*s}%;top:${100*t.y}%`}></span>${ks(e,`glass probe ${s>.6?"west":""}`)}`}function ks(e,t){let s=e.probed;if(!e.state.probe||!s)return"";let[i,a]=e.renderer.pictureSize(e.state),n=p`<button class="xs dim" title="Close (P or Esc)" @click=${()=>e.set({probe:""})}><kbd>P</kbd>close</button>`,o=p`<h3>Probe <span class="dim">pixel ${Math.floor(s.x*i)}, ${Math.floor(s.y*a)}</span><span class="sp"></span>${n}</h3>`;if(!s.found)return p`<section class=${t} aria-label="Probe">${o}<p class="dim">Not on the material.</p></section>`;let{wi:r,wo:l}=s.found,c=Math.atan2(r[1],r[0])-Math.atan2(l[1],l[0]),u=Math.abs((c*180/Math.PI+540)%360-180),h=f=>f.letter==="B"?"isB":"";return p`<section class=${t} aria-label="Probe">${o}
        <table class="dirs"><tbody>${[["ωi",r],["ωo",l]].map(([f,v])=>p`<tr><td>${f}</td>${v.map(m=>p`<td>${U(m,3)}</td>`)}</tr>`)}<tr><td>angles</td><td colspan="3">θi ${ws(r[2])}&ensp;θo ${ws(l[2])}&ensp;φ ${U(u,1)}°</td></tr></tbody></table><hr><table><tbody><tr><th scope="col"><span class="sr">Quantity</span></th><th scope="col">R</th><th scope="col">G</th><th scope="col">B</th></tr>
            ${s.values.map(f=>p`<tr class=${h(f)} data-probe=${`f${f.letter}`}><td>f${e.two?p`&ensp;${f.letter}`:""}</td>${f.f.map(v=>p`<td data-value=${v}>${U(v)}</td>`)}</tr>`)}
            ${s.values.map(f=>p`<tr class=${h(f)} data-probe=${`albedo${f.letter}`}><td>albedo ${e.two?f.letter:""}</td>${f.albedo.map(v=>p`<td data-value=${v}>${U(v)}</td>`)}</tr>`)}
            ${s.values.length?p`<tr data-probe="pdf"><td>pdf</td><td colspan="3">${s.values.map(f=>U(f.pdf)).filter((f,v,m)=>m.indexOf(f)===v).join(", ")} /sr${s.values.length===2&&U(s.values[0].pdf)===U(s.values[1].pdf)?", both":""}</td></tr>`:""}</tbody></table></section>`}var Ms=e=>p`<label class="thetao">θo <b>${Math.round(e.state.theta)}°</b><input type="range" min="0" max="89" step="1" aria-label="Angle of the viewer" .value=${String(e.state.theta)} .style=${`--f:${100*e.state.theta/89}%`} @input=${t=>e.set({theta:t.target.valueAsNumber},"theta")}></label>`,_s=e=>p`<select class="channel" aria-label="Channel" .value=${String(e.channel)} @change=${t=>{e.channel=Number(t.target.value),e.update()}}>${he.map((t,s)=>p`<option value=${s} ?selected=${s===e.channel}>${t}</option>`)}</select>`,As=e=>e.plots().map(t=>p`<span class="map"><canvas data-map=${t.letter} role="img" aria-label=${`f of ${t.letter} over half and difference angle`}></canvas>${e.two?p`<b class="k ${t.letter==="B"?"kb":""}">${t.letter}</b>`:""}<small class="y">90°</small><small class="y0">θd</small><small class="x0">0°</small><small class="xm">θh</small><small class="x1">90°</small></span>`);function Ri(e){let t=e.state,s=e.start.environments,i=()=>Di(e);return p`<section class="light" aria-label="Light"><button class="sw" role="switch" aria-checked=${t.furnace} title="Radiance 1 from everywhere (F)" @click=${()=>e.set({furnace:!t.furnace})}><i></i>Furnace</button><div class="envs w">${Object.keys(s).map(a=>p`<button class=${`env-${a}`} aria-pressed=${t.env===a} title=${a} @click=${()=>e.set({env:a})}><canvas data-env=${a} aria-hidden="true"></canvas><span>${a}</span></button>`)}${e.renderer?.sky?p`<button aria-pressed=${t.env==="own"} @click=${()=>e.set({env:"own"})}><span>own</span></button>`:""}<button class="drop h" aria-label="Open an HDR picture or a mesh" title="Drop .hdr, .exr, .obj or .glb anywhere, or choose a file" @click=${i}>Drop<br>HDR, OBJ</button></div><div class="g"><label>Turn light<b>${Math.round(t.turn)}°</b></label><input type="range" class="bi" aria-label="Turn light" min="-180" max="180" .value=${String(t.turn)} @input=${a=>e.set({turn:a.target.valueAsNumber},"turn")} @dblclick=${()=>e.set({turn:0})}></div><div class="g"><label>Exposure<b>${t.ev<0?"−":"+"}${Math.abs(t.ev).toFixed(1)} EV</b></label><input type="range" class="bi" aria-label="Exposure" min="-6" max="6" step=".1" .value=${String(t.ev)} @input=${a=>e.set({ev:a.target.valueAsNumber},"ev")} @dblclick=${()=>e.set({ev:0})}></div><div class="g tone"><select aria-label="Tone curve" .value=${t.tone} @change=${a=>e.set({tone:a.target.value})}>${["none","reinhard","filmic"].map(a=>p`<option value=${a} ?selected=${a===t.tone}>Tone: ${a}</option>`)}</select></div><div class="g shape"><select aria-label="Shape" .value=${t.shape} @change=${a=>a.target.value==="open"?i():e.set({shape:a.target.value})}>${[["ball","Ball"],["sphere","Sphere"],...e.renderer?.own?[["own","Own mesh"]]:[],["open","Open mesh …"]].map(([a,n])=>p`<option value=${a} ?selected=${a===t.shape}>${n}</option>`)}</select></div><div class="phone w" role="group" aria-label="Compare and share">${e.two?p`<div class="seg">${$s.map(([a,n])=>p`<button aria-pressed=${t.cmp===a} @click=${()=>e.set({cmp:a})}>${n}</button>`)}</div>`:""}
            <div class="row"><button class="btn" @click=${()=>e.compare()}>${e.two?"Stop comparing":"Compare"}</button><button class="btn" @click=${()=>e.copy(e.link(),"The link")}>Copy link</button><button class="btn" @click=${()=>e.savePicture()}>Save picture</button></div></div></section>`}function Di(e){let t=document.createElement("input");t.type="file",t.accept=".hdr,.exr,.obj,.glb",t.onchange=()=>t.files[0]&&e.take(t.files[0]),t.click()}function Fi(e){let t=e.state,s=e.plots(),i=(n,o,r)=>p`<figcaption>${n}<span>${o}</span><button class="ib" aria-label=${`Show ${n} large`} title="Show large" @click=${()=>e.set({view:r})}>${S("large")}</button></figcaption>`,a=()=>p`<div class="plots"><figure>${i("Lobe slice","f cos θi, log radius, 1/sr","slices")}${s.length?jt(e,"polar","Slice of the lobe, logarithmic radius",(n,o)=>ue(s,e.channel,n,o)):""}</figure><figure>${i("Albedo",`over θo, ${he[e.channel]}`,"albedo")}${s.length?jt(e,"albedo","Directional albedo",(n,o)=>de(s,e.channel,n,o,t.theta)):""}</figure><figure>${i("Half and difference angle","f","map")}<div class="maps">${As(e)}</div></figure>${ks(e,"probe docked")}</div>`;return p`<section class="dock"><div class="tabs" role="tablist" aria-label="Dock">${bs.map(([n,o])=>p`<button role="tab" aria-selected=${t.dock===n} @click=${()=>e.set({dock:n})}>${o}</button>`)}<span class="sp"></span>${t.dock==="plots"?p`${Ms(e)}${_s(e)}${e.two?p`<span class="xs dim row lg"><i class="la"></i>A<i class="lb"></i>B</span>`:""}`:""}</div><div class="pane ${t.dock==="plots"?"":t.dock}">${t.dock==="plots"?a():e.more(n=>t.dock==="code"?n.codePane(e):n.aboutPane(e))}</div></section>`}var Ss={albedo:de,axes:fe,channels:_s,chart:jt,direction:tt,html:p,layersOf:W,line:Ft,mapCanvases:As,packRows:ut,path:K,pick:it,polar:ue,svg:A,theta:Ms};var $e=["picture","lobe","slices","map","albedo","weights"];function Ps(e){let t=e.options.keys??document,s=i=>{let a=i.composedPath()[0];if(a instanceof HTMLInputElement&&a.type!=="range"||a instanceof HTMLTextAreaElement||a instanceof HTMLSelectElement||i.altKey)return;let n=i.key.length===1?i.key.toLowerCase():i.key,o=e.two;if(i.ctrlKey||i.metaKey){n==="z"&&(i.preventDefault(),e.step(i.shiftKey?1:-1)),n==="y"&&(i.preventDefault(),e.step(1));return}let r=c=>()=>o&&e.set({cmp:c}),l={a:r("A"),b:r("B"),w:r("wipe"),s:r("side"),d:r("diff"),k:r("flick"),x:()=>e.swap(),c:()=>e.compare(),f:()=>e.set({furnace:!e.state.furnace}),l:()=>e.set({turn:(e.state.turn+195)%360-180},"turn"),"[":()=>e.set({ev:Math.round((e.state.ev-1/3)*1e3)/1e3},"ev"),"]":()=>e.set({ev:Math.round((e.state.ev+1/3)*1e3)/1e3},"ev"),p:()=>e.state.probe&&!e.pointer?e.set({probe:""}):e.probe(...e.pointer??we),v:()=>e.set({view:$e[($e.indexOf(e.state.view)+1)%$e.length]}),"?":()=>{e.help=!e.help,e.update()},Escape:()=>{e.help=e.menu=!1,e.picking="",e.state.probe&&e.set({probe:""}),e.update()}};if(/^[1-9]$/.test(n)){e.set({layer:Number(n)-1});return}l[n]&&(i.preventDefault(),l[n]())};return t.addEventListener("keydown",s),()=>t.removeEventListener("keydown",s)}var ji="The picture and its sliders go on. New models, choices and code need it: start it again, and paste this page's link behind its address.",Gi=16,qi=2e4,Gt=class{constructor(t,s,i={}){Object.assign(this,{root:t,source:s,options:i,sizes:{},data:{},lobes:{},statistics:null,notes:[],code:{},language:"wgsl"}),this.state={...et},this.sides=[new bt("A")],this.openColours=new Set,this.channel=3,this.lobe={az:-62,el:22,log:!0,weights:!0},this.wanted=i.graphics??"",this.coming={},this.late=new Map,this.looks=0,this.replaced=[]}more(t,s=""){return this.loaded?t(this.loaded):(this.#t().then(i=>{this.loaded=i,this.update()},i=>this.say("This view cannot be loaded.",i.message,"warn")),s)}async do(t,...s){return(await this.#t())[t](this,...s)}async#t(){let t=await this.part("more");return t.share(Ss),t}part(t){return this.coming[t]??=this.source.part(t)}async open(){let{state:t,bad:s}=It(this.options.fragment??""),[i,{gpu:a,reason:n}]=await Promise.all([this.source.start(),Bt(this.source,this.wanted).catch(o=>({gpu:null,reason:o.message}))]);return this.start=i,Object.assign(this.state,ns(t,this.start.environments,s)),this.state.a||(this.state.a=this.start.show[0]??"eon"),!this.state.b&&!("a"in t)&&this.start.show[1]&&(this.state.b=this.start.show[1]),this.state.b?"cmp"in t||(this.state.cmp="wipe"):this.state.cmp="A",s.length&&this.say("This link was taken in part.",`Not understood: ${[...new Set(s)].filter(Boolean).join(", ")||"a part without a name"}.`),a?this.#s(a):this.say("No picture can be drawn here.",n,"warn"),a?.name==="WebGL2"&&!this.wanted&&this.say("WebGL2 is used instead of WebGPU.",`${n} All views work; shaders compile more slowly.`),this.update(),setTimeout(()=>this.renderer?.prepare({...this.state})),await this.#a(),this.history=new Ct(this.#d()),this.openColours.add(this.edited().payload?.parameters.find(o=>o.kind==="reflectance")?.path),this.#f(),this.source.watch(o=>this.#m(o)),this.update(),this}#s(t){this.renderer?this.renderer.replace(t):(this.renderer=new Ot(t,this.start,s=>this.#v(s)),this.renderer.sides=this.sides,this.renderer.failed=s=>{this.failedOn!==this.gpu&&(this.failedOn=this.gpu,this.failures=(this.failures??0)+1,this.say("The picture stopped.",s.message,"warn"),this.failures<4&&this.#e(this.gpu))},this.renderer.run()),this.gpu=t,t.lost.then(s=>{(t===this.gpu&&!this.closed&&s.reason!=="destroyed"||this.testLoss)&&this.#e(t)})}async#e(t){if(this.closed||t!==this.gpu)return;this.testLoss=!1,this.gpu=null;let s=t.name==="WebGPU"&&performance.now()-(this.lostAt??-1/0)<qi;this.lostAt=performance.now(),s&&(this.wanted="webgl2");let i=await Bt(this.source,this.wanted).catch(a=>({reason:a.message}));if(!i.gpu){this.say("The GPU was lost.",`${i.reason} The last picture stays.`,"warn");return}this.#s(i.gpu),this.update(),await Promise.all(this.sides.map(a=>this.#o(a))),this.say(s?"WebGL2 is used instead of WebGPU.":"The GPU was lost and is back.",`${s?"The GPU was lost twice. ":""}Everything was restored from the page's state; the picture starts again.`),this.moved(!1)}get two(){return this.sides.length>1}async#a(){!!this.state.b!==this.two&&(this.sides.length=1,this.state.b&&this.sides.push(new bt("B")),this.two||Object.assign(this.state,{cmp:"A",edit:"A"})),await Promise.all(this.sides.map(t=>this.#i(t,this.state[t.letter.toLowerCase()])))}async#i(t,s){let i=t.turn=(t.turn??0)+1,a=setTimeout(()=>{t.busy="compiling …",this.update()},200);try{let n=await this.payload(s);if(t.turn!==i)return!1;await this.#n(t,n);let o=t.payload,r=o&&{program:t.program,values:t.values,options:t.options,models:t.models},l=o&&t.program&&["code","hooks"].every(c=>Hi(o[c],n[c]))&&o.tables?.rows===n.tables?.rows;if(t.take(n),l)t.active.values=t.values;else{try{await this.#o(t,i)}catch(c){throw o&&Object.assign(t,{payload:o,...r}),new Error(`This GPU's driver refuses the shader: ${c.message}`)}if(t.turn!==i)return!1}return t.error="",this.state[t.letter.toLowerCase()]=t.text(),this.#r(t),this.moved(),!0}catch(n){if(t.turn!==i)return!1;if(t.error={title:s.length>80?`${s.slice(0,77)}…`:s,text:`${n.message} ${t.payload?"The picture is of the last model that worked.":""}`},!t.payload){let o=this.start.show.find(l=>l!==s)??"eon",{error:r}=t;s!==o&&await this.#i(t,o)&&(t.error=r,this.say(`${r.title} cannot be shown.`,`${n.message} ${o} is shown instead.`,"warn"))}return!1}finally{clearTimeout(a),t.turn===i&&(t.busy=""),this.update()}}payload(t){if(!this.source.live)return this.source.model(t);let{[t]:s}=this.start.models,i=this.late.get(t)??(s?Promise.resolve(s):this.source.model(t));return delete this.start.models[t],this.late.delete(t),this.late.set(t,i),i.catch(()=>this.late.delete(t)),this.late.size>Gi&&this.late.delete(this.late.keys().next().value),i}async#n(t,s){let i=(u,h)=>!u||h in u.code;if(!this.gpu||i(s,this.gpu.language))return;let a=this.sides.find(u=>u!==t),n=this.gpu.language==="wgsl"?"webgl2":"webgpu",o=Object.keys(s.code)[0];if(!i(a?.payload,o))throw new Error(`${s.foreign.language} and ${a.payload.foreign.language} run in different interfaces of the browser and cannot be shown side by side; compare each with a model of gonio's.`);let{gpu:r,reason:l}=await Bt(this.source,n);if(r.language!==o)throw r.close(),new Error(`${s.foreign.language} needs WebGPU. ${l}`);this.wanted=n;let c=this.gpu;this.#s(r),c.close(),a?.payload&&await this.#o(a),this.say(`${r.name} is used now.`,`${s.name} is ${s.foreign.language} and runs there as it stands.`,"info",6e3)}async#o(t,s=t.turn){if(!this.gpu)return;let{gpu:i}=this,a=await this.#h(t),n=await this.renderer.hold(i.compile(a.payload));if(t.turn!==s||i!==this.gpu)return;t.active={...a,values:t.values};let o=t.program;t.program=n,t.samples=0,t.epoch=-1,o?.model&&t.film&&this.replaced.push(()=>i.forget(o))}async#h(t){if(!t.hidden.size)return{payload:t.payload,path:n=>n};let{text:s,path:i}=(await this.#t()).visible(t);return{payload:{...await this.source.model(s),hooks:[]},path:i}}async#r(t){let{payload:s}=t;if(!(!this.source.live||!s.options.length))try{let{options:i,unused:a}=await this.source.options(t.text());if(t.payload===s){s.options=i.map(n=>({...n,value:t.options.get(n.path)}));for(let n of s.parameters)n.unused_because??=a[n.path];this.update()}}catch{}}async#m({file:t,ended:s}){if(s!==void 0){this.ended&&this.dismiss(this.ended),this.ended=s&&this.say("gonio view has stopped.",ji,"warn");return}this.late.clear();for(let i of this.sides)i.payload?.name===t&&await this.#i(i,i.text())&&this.say(`${t} was read again.`,"","info",3e3)}edited(){return this.state.edit==="B"&&this.two?this.sides[1]:this.sides[0]}editing(){return this.state.edit==="AB"&&this.two?this.sides:[this.edited()]}layerIndex(){return Math.min(this.state.layer,W(this.edited()).length-1)}differs(t){if(!this.two||!this.sides[1].payload||!this.sides[0].payload)return!1;let[s,i]=this.sides.map(a=>a.options.get(t));return s!==void 0&&i!==void 0&&s!==i}set(t,s=""){Object.assign(this.state,t),["furnace","env","turn","shape","az","el","dist"].some(a=>a in t)?this.moved():this.renderer?.refresh(this.state),"cmp"in t&&(this.moved(!1),this.#f()),("theta"in t||"view"in t||"dock"in t)&&this.#c(),"dock"in t&&this.#u(),this.#l(s||Object.keys(t).join()),this.update()}#f(){clearInterval(this.flickering),!(this.state.cmp!=="flick"||!this.renderer)&&(this.flickering=setInterval(()=>{this.renderer.flicker=!this.renderer.flicker,this.renderer.show()},500))}setParameter(t,s){this.setParameters({[t]:s})}setParameters(t,s=Object.keys(t).join()){this.fieldError=null;for(let i of this.editing()){for(let[a,n]of Object.entries(t))i.values.has(a)&&i.values.set(a,n.slice());this.state[i.letter.toLowerCase()]=i.text()}this.moved(),this.#l(s),this.options.changed?.(this),this.update()}resetParameter(t){let s=this.edited().parameter(t);this.setParameters({[t]:this.edited().startOf(t,s.default)},"")}async setOptions(t){this.refused=null;for(let s of this.editing()){let i=Object.fromEntries(Object.entries(t).filter(([a])=>s.options.has(a)||s.models.has(a)));!Object.keys(i).length||await this.change(s,s.text(i))||await this.#p(s,i)}}async#p(t,s){await this.#r(t);for(let[i,a]of Object.entries(s)){let n=t.payload?.options.find(o=>o.path===i)?.values.find(o=>o.value===a&&!o.allowed);if(n){t.error="",this.refuse(i,n);return}}}async change(t,s){let i=await this.#i(t,s);return i&&(this.#l(),this.options.changed?.(this)),this.update(),i}chooseModel(t,s){for(let i of this.editing())i.hidden.clear(),t.prefix?this.change(i,i.text({[t.prefix.slice(0,-1)]:s})):this.change(i,s)}async hide(t){for(let s of this.editing()){s.hidden.delete(t)||s.hidden.add(t);try{await this.#o(s)}catch(i){this.say("This layer cannot be hidden.",i.message,"warn"),s.hidden.clear()}}this.moved(!1),this.update()}async compare(t=!this.two,s=""){t&&!this.two?(this.state.b=s||this.sides[0].text(),this.state.cmp="wipe",this.state.edit="B"):t||Object.assign(this.state,{b:"",cmp:"A",edit:"A"}),await this.#a(),this.#l(),this.moved(!1),this.options.changed?.(this),this.update()}swap(){this.two&&(this.sides.reverse(),this.sides.forEach((t,s)=>{t.letter="AB"[s],this.state["ab"[s]]=t.text()}),this.renderer?.refresh(this.state),this.#c(),this.#l(),this.update())}toggleColour(t){this.openColours.delete(t)||this.openColours.add(t),this.update()}refuse(t,s){this.refused=t&&{path:t,...s},this.update()}fail(t){this.fieldError=t,this.update()}say(t,s="",i="info",a=0){let n={title:t,text:s,kind:i};return this.notes=[...this.notes.slice(-2),n],a&&setTimeout(()=>this.dismiss(n),a),this.update(),n}dismiss(t){this.notes=this.notes.filter(s=>s!==t),this.update()}moved(t=!0){this.looks++,this.renderer?.restart({...this.state},{moving:t}),this.statistics=null,this.#c(),this.#u()}#d(){return{...this.state}}#l(t){this.history?.add(this.#d(),t),this.options.linked?.(Nt(this.state))}async step(t){let s=this.history.step(t);if(s){Object.assign(this.state,s);for(let i of this.sides)i.hidden.clear();await this.#a(),this.moved(!1),this.options.linked?.(Nt(this.state)),this.options.changed?.(this),this.update()}}link(){return`${this.options.address??location.href.split("#")[0]}#${Nt(this.state)}`}show(t,s="a"){let i=this.sides[s==="a"?0:1];return i&&i.text()!==t?this.change(i,t):null}async follow(t){return!t==!this.two?t?this.show(t,"b"):null:this.compare(!!t,t)}async copy(t,s){try{await navigator.clipboard.writeText(t),this.say(`${s} is copied.`,"","info",2500)}catch{this.say(`${s} could not be copied; here it is.`,t)}}async savePicture(){return(await this.part("more")).savePicture(this)}async take(t){try{let{openFile:s}=await this.part("files"),i=await s(t);i.picture?(this.renderer.sky=i.picture,this.set({env:"own",furnace:!1}),this.moved(!1)):(this.renderer.own=i,this.renderer.scenes.clear(),this.set({shape:"own"}),this.moved(!1)),this.say(`${t.name} is shown.`,i.note??"","info",4e3)}catch(s){let i=/\.(obj|glb|gltf)$/i.test(t.name)?`The shape is still “${this.state.shape}”.`:`The light is still “${this.state.env}”.`;this.say(`${t.name} was not taken.`,`${s.message} ${i}`,"warn")}}#v(t){let s=t.samples;s>=4&&(s&s-1)===0&&t.scale===1&&this.#w(),this.#g()}#g(){this.progress??=setTimeout(()=>{this.progress=null,this.update()},150)}async#w(){let{epoch:t}=this.renderer;try{let s=await this.renderer.statistics();s&&this.renderer.epoch===t&&(this.statistics=s,this.update())}catch{}}#c(){clearTimeout(this.measuring),this.measuring=setTimeout(()=>this.#$(),60)}async#$(){if(!this.gpu||this.busyMeasuring||!(this.renderer.begun||this.renderer.paused)){this.gpu&&this.#c();return}this.busyMeasuring=!0;try{for(let t of this.sides){if(!t.program)continue;let{letter:s}=t,i=`${t.active.payload.text}|${JSON.stringify([...t.active.values])}|${this.state.theta}`,a=["lobe","weights"].includes(this.state.view);this.data[s]?.key!==i&&(this.data[s]={...await Ee(this.gpu,t,this.state.theta),letter:s,key:i});let{lobe:n}=a?await this.#t():{};a&&this.lobes[s]?.key!==i&&(this.lobes[s]={...await n(this.gpu,t,this.state.theta),letter:s,key:i})}await this.#b()}catch(t){this.gpu&&(this.plotError=t.message)}this.busyMeasuring=!1;for(let t of this.replaced.splice(0))t();this.update()}plots(){return this.sides.map(t=>this.data[t.letter]).filter(Boolean)}bodies(){return this.sides.map(t=>this.lobes[t.letter]).filter(Boolean)}probe(t,s){this.looks++,this.probed=null;let i={probe:`${t.toFixed(4)},${s.toFixed(4)}`},a=this.surface(t,s);a&&(i.theta=Math.min(89,Math.round(Math.acos(Math.min(1,a.wo[2]))*180/Math.PI))),this.set(i,"probe"),this.#c()}async#b(){let[t,s]=this.state.probe.split(",").map(Number);if(!this.state.probe||!Number.isFinite(t)||!Number.isFinite(s)){this.probed=null;return}let{looks:i}=this,a=this.surface(t,s),n={x:t,y:s,found:a,values:[]};for(let o of a?this.sides.filter(r=>r.program):[]){let{wi:r,wo:l,growth:c,uv:u,t:h}=a,f=c===void 0||!o.payload.hooks.length,{program:v}=o,m=o.packed(f?{}:o.overrides(u,c,h,o.mapData??o.maps())),d=await this.gpu.rows(v,m,ut([[r,l]])),g=f&&!o.hidden.size&&o.payload.sums&&this.source.live,w=g?await this.source.albedo(o.text(),l):await this.gpu.albedo(v,m,new Float32Array([...l,0])),{letter:$}=o;n.values.push({letter:$,f:[...d.slice(0,3)],pdf:d[3],albedo:[...w.slice(0,3)]})}i===this.looks&&(this.probed=n)}surface(t,s){return ss(this.renderer,this.state,t,s)}#u(){this.state.dock==="code"&&(clearTimeout(this.coding),this.coding=setTimeout(()=>this.#y(),120))}async#y(){let t=this.edited(),{language:s}=this;if(!t.payload)return;let i=t.text(),a;try{a={text:await this.source.code(i,s),of:i}}catch(n){a={error:n.message}}s!==this.language||t!==this.edited()||i!==t.text()||(this.code=a,this.update())}setLanguage(t){this.language=t,this.code={},this.#u(),this.update()}update(){this.drawing||this.closed||(this.drawing=!0,requestAnimationFrame(()=>{this.drawing=!1,this.closed||this.draw()}))}draw(){if(!this.start)return;Te(ys(this),this.root);for(let r of this.root.querySelectorAll("[data-value]"))r.value=r.dataset.value;let t=this.root.querySelector(".canvas");this.gpu&&t&&this.gpu.canvas.parentNode!==t&&(t.replaceChildren(this.gpu.canvas),this.#x(t));let s=!1;for(let r of this.root.querySelectorAll("[data-chart]")){let l=r.clientWidth||r.getBoundingClientRect().width,c=r.clientHeight||r.getBoundingClientRect().height,u=this.sizes[r.dataset.chart];l&&(u?.width!==l||u?.height!==c)&&(this.sizes[r.dataset.chart]={width:l,height:c},s=!0)}let i=Math.min(devicePixelRatio,2);for(let r of this.root.querySelectorAll("canvas[data-map]")){let l=this.data[r.dataset.map];l&&r.drawn!==l.key&&(hs(r,l.map),r.drawn=l.key)}let a=this.root.querySelector("canvas.lobe"),n=this.root.querySelector("canvas.weights");a&&this.bodies().length&&this.loaded.drawLobe(a,this.bodies(),this.lobe,i),n&&this.bodies().length&&this.loaded.drawWeights(n,this.bodies(),i),this.renderer?.begun&&this.more(r=>{for(let l of this.root.querySelectorAll("canvas[data-env]:not(.drawn)"))r.drawThumb(l,this.start.environments[l.dataset.env]),l.className="drawn"});let o=this.root.querySelector(".card");o!==this.card&&(o&&(this.before??=this.root.activeElement),(o?.querySelector("input, button")??this.before)?.focus(),o||(this.before=null),this.card=o),s&&this.update()}#x(t){this.observer?.disconnect(),this.observer=new ResizeObserver(([s])=>{let i=s.devicePixelContentBoxSize?.[0],a=Math.min(devicePixelRatio,2)/devicePixelRatio,n=Math.max(16,Math.round((i?i.inlineSize:s.contentRect.width*devicePixelRatio)*a)),o=Math.max(16,Math.round((i?i.blockSize:s.contentRect.height*devicePixelRatio)*a)),{canvas:r}=this.gpu??{};!r||r.width===n&&r.height===o||(r.width=n,r.height=o,this.renderer.size=[n,o],this.renderer.show(),this.moved(!1))});try{this.observer.observe(t,{box:"device-pixel-content-box"})}catch{this.observer.observe(t)}this.unlisten??=Ps(this)}close(){this.closed=!0,this.observer?.disconnect(),this.unlisten?.(),clearTimeout(this.measuring),clearInterval(this.flickering),this.renderer?.close()}},Hi=(e,t)=>JSON.stringify(e)===JSON.stringify(t);async function Us(e,t,s={}){let i=e.attachShadow({mode:"open"}),a=new CSSStyleSheet;return a.replaceSync(await t.file("viewer.css")),i.adoptedStyleSheets=[a],new Gt(i,t,s).open()}async function Wi(){let e=document.getElementById("gonio-data"),t=document.createElement("div");document.body.append(t),document.documentElement.style.height=document.body.style.height="100%",document.body.style.margin="0";let s=location.hash,i=/(?:^#|&)token=([\w-]+)/.exec(s)?.[1],a,n=r=>history.replaceState(null,"",`#${r}`);if(e){let r=Uint8Array.from(atob(e.textContent.trim()),c=>c.charCodeAt(0)),l=await new Response(new Blob([r]).stream().pipeThrough(new DecompressionStream("gzip"))).text();a=new St(JSON.parse(l))}else i&&sessionStorage.setItem("gonio-token",i),a=new At(i??sessionStorage.getItem("gonio-token")??"");let o=new URLSearchParams(location.search).get("graphics")??"";try{let r=s.replace(/(^#|&)token=[\w-]+&?/,"$1");globalThis.gonio=await Us(t,a,{fragment:r,linked:n,graphics:o,themed:c=>{document.documentElement.style.colorScheme=c}}),document.title=`${globalThis.gonio.sides.map(c=>c.text()).join(" | ").slice(0,120)} – gonio view`,addEventListener("hashchange",()=>{let{state:c}=It(location.hash);c.a&&location.reload()})}catch(r){t.textContent=r.message,t.style.cssText="font:15px sans-serif;padding:48px;max-width:60ch"}}async function Vi({model:e,el:t}){let s=document.createElement("div");s.className="embedded",s.style.height=`${e.get("height")}px`,t.append(s);let i=()=>["a","b"].filter(r=>e.get(r)).map(r=>`${r}=${encodeURIComponent(e.get(r))}`).join("&"),a=r=>{for(let[l,c]of["a","b"].entries())e.set(c,r.sides[l]?.payload?r.sides[l].text():"");e.save_changes()},n=await Us(s,new Pt(e),{fragment:`${i()}&${e.get("settings")}`,keys:s,changed:a,linked:r=>{e.set("link",r),e.save_changes()}}),o={"change:a":()=>n.show(e.get("a"),"a"),"change:b":()=>n.follow(e.get("b"))};for(let[r,l]of Object.entries(o))e.on(r,l);return()=>{for(let[r,l]of Object.entries(o))e.off(r,l);n.close()}}var Mn={render:Vi};(document.getElementById("gonio-data")||document.querySelector('script[src="/viewer.js"]'))&&Wi();export{Mn as default,Us as mount};
