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

parse-exr
Copyright (C) 2024 Damien Seguin

Permission is hereby granted, free of charge, to any person obtaining a copy
of this software and associated documentation files (the "Software"), to deal
in the Software without restriction, including without limitation the rights
to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
copies of the Software, and to permit persons to whom the Software is
furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in
all copies or substantial portions of the Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM,
OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN
THE SOFTWARE.

fflate
MIT License

Copyright (c) 2026 Arjun Barrett

Permission is hereby granted, free of charge, to any person obtaining a copy
of this software and associated documentation files (the "Software"), to deal
in the Software without restriction, including without limitation the rights
to use, copy, modify, merge, publish, distribute, sublicense, and/or sell
copies of the Software, and to permit persons to whom the Software is
furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all
copies or substantial portions of the Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR
IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF MERCHANTABILITY,
FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER
LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM,
OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE
SOFTWARE.
*/
var ws=Object.defineProperty;var Zn=(n,t,e)=>()=>{if(e)throw e[0];try{return n&&(t=n(n=0)),t}catch(i){throw e=[i],i}};var ys=(n,t)=>{for(var e in t)ws(n,e,{get:t[e],enumerable:!0})};function Ue(n,t){return ho(n.subarray(uo(n,t&&t.dictionary),-4),{i:2},t&&t.out,t&&t.dictionary)}var St,ae,eo,Gi,qi,no,Zi,Wi,ji,io,Yi,ro,Xa,kn,Rt,K,Se,ze,K,K,K,K,Vi,K,so,oo,bn,zt,$n,ao,lo,co,Ut,ho,fo,uo,po,mo,Ki=Zn(()=>{St=Uint8Array,ae=Uint16Array,eo=Int32Array,Gi=new St([0,0,0,0,0,0,0,0,1,1,1,1,2,2,2,2,3,3,3,3,4,4,4,4,5,5,5,5,0,0,0,0]),qi=new St([0,0,0,0,1,1,2,2,3,3,4,4,5,5,6,6,7,7,8,8,9,9,10,10,11,11,12,12,13,13,0,0]),no=new St([16,17,18,0,8,7,9,6,10,5,11,4,12,3,13,2,14,1,15]),Zi=function(n,t){for(var e=new ae(31),i=0;i<31;++i)e[i]=t+=1<<n[i-1];for(var r=new eo(e[30]),i=1;i<30;++i)for(var s=e[i];s<e[i+1];++s)r[s]=s-e[i]<<5|i;return{b:e,r}},Wi=Zi(Gi,2),ji=Wi.b,io=Wi.r;ji[28]=258,io[258]=28;Yi=Zi(qi,0),ro=Yi.b,Xa=Yi.r,kn=new ae(32768);for(K=0;K<32768;++K)Rt=(K&43690)>>1|(K&21845)<<1,Rt=(Rt&52428)>>2|(Rt&13107)<<2,Rt=(Rt&61680)>>4|(Rt&3855)<<4,kn[K]=((Rt&65280)>>8|(Rt&255)<<8)>>1;Se=(function(n,t,e){for(var i=n.length,r=0,s=new ae(t);r<i;++r)n[r]&&++s[n[r]-1];var o=new ae(t);for(r=1;r<t;++r)o[r]=o[r-1]+s[r-1]<<1;var c;if(e){c=new ae(1<<t);var l=15-t;for(r=0;r<i;++r)if(n[r])for(var h=r<<4|n[r],u=t-n[r],d=o[n[r]-1]++<<u,g=d|(1<<u)-1;d<=g;++d)c[kn[d]>>l]=h}else for(c=new ae(i),r=0;r<i;++r)n[r]&&(c[r]=kn[o[n[r]-1]++]>>15-n[r]);return c}),ze=new St(288);for(K=0;K<144;++K)ze[K]=8;for(K=144;K<256;++K)ze[K]=9;for(K=256;K<280;++K)ze[K]=7;for(K=280;K<288;++K)ze[K]=8;Vi=new St(32);for(K=0;K<32;++K)Vi[K]=5;so=Se(ze,9,1),oo=Se(Vi,5,1),bn=function(n){for(var t=n[0],e=1;e<n.length;++e)n[e]>t&&(t=n[e]);return t},zt=function(n,t,e){var i=t/8|0;return(n[i]|n[i+1]<<8)>>(t&7)&e},$n=function(n,t){var e=t/8|0;return(n[e]|n[e+1]<<8|n[e+2]<<16)>>(t&7)},ao=function(n){return(n+7)/8|0},lo=function(n,t,e){return(t==null||t<0)&&(t=0),(e==null||e>n.length)&&(e=n.length),new St(n.subarray(t,e))},co=["unexpected EOF","invalid block type","invalid length/literal","invalid distance","stream finished","no stream handler",,"no callback","invalid UTF-8 data","extra field too long","date not in range 1980-2099","filename too long","stream finishing","invalid zip data"],Ut=function(n,t,e){var i=new Error(t||co[n]);if(i.code=n,Error.captureStackTrace&&Error.captureStackTrace(i,Ut),!e)throw i;return i},ho=function(n,t,e,i){var r=n.length,s=i?i.length:0;if(!r||t.f&&!t.l)return e||new St(0);var o=!e,c=o||t.i!=2,l=t.i;o&&(e=new St(r*3));var h=function(ue){var Ne=e.length;if(ue>Ne){var pe=new St(Math.max(Ne*2,ue));pe.set(e),e=pe}},u=t.f||0,d=t.p||0,g=t.b||0,k=t.l,v=t.d,p=t.m,w=t.n,b=r*8;do{if(!k){u=zt(n,d,1);var A=zt(n,d+1,3);if(d+=3,A)if(A==1)k=so,v=oo,p=9,w=5;else if(A==2){var I=zt(n,d,31)+257,G=zt(n,d+10,15)+4,Y=I+zt(n,d+5,31)+1;d+=14;for(var J=new St(Y),O=new St(19),D=0;D<G;++D)O[no[D]]=zt(n,d+D*3,7);d+=G*3;for(var Z=bn(O),V=(1<<Z)-1,rt=Se(O,Z,1),D=0;D<Y;){var nt=rt[zt(n,d,V)];d+=nt&15;var T=nt>>4;if(T<16)J[D++]=T;else{var X=0,vt=0;for(T==16?(vt=3+zt(n,d,3),d+=2,X=J[D-1]):T==17?(vt=3+zt(n,d,7),d+=3):T==18&&(vt=11+zt(n,d,127),d+=7);vt--;)J[D++]=X}}var Et=J.subarray(0,I),wt=J.subarray(I);p=bn(Et),w=bn(wt),k=Se(Et,p,1),v=Se(wt,w,1)}else Ut(1);else{var T=ao(d)+4,B=n[T-4]|n[T-3]<<8,W=T+B;if(W>r){l&&Ut(0);break}c&&h(g+B),e.set(n.subarray(T,W),g),t.b=g+=B,t.p=d=W*8,t.f=u;continue}if(d>b){l&&Ut(0);break}}c&&h(g+131072);for(var kt=(1<<p)-1,Dt=(1<<w)-1,xt=d;;xt=d){var X=k[$n(n,d)&kt],ft=X>>4;if(d+=X&15,d>b){l&&Ut(0);break}if(X||Ut(2),ft<256)e[g++]=ft;else if(ft==256){xt=d,k=null;break}else{var It=ft-254;if(ft>264){var D=ft-257,Ht=Gi[D];It=zt(n,d,(1<<Ht)-1)+ji[D],d+=Ht}var tt=v[$n(n,d)&Dt],Ct=tt>>4;tt||Ut(3),d+=tt&15;var wt=ro[Ct];if(Ct>3){var Ht=qi[Ct];wt+=$n(n,d)&(1<<Ht)-1,d+=Ht}if(d>b){l&&Ut(0);break}c&&h(g+131072);var Nt=g+It;if(g<wt){var Pe=s-wt,rn=Math.min(wt,Nt);for(Pe+g<0&&Ut(3);g<rn;++g)e[g]=i[Pe+g]}for(;g<Nt;++g)e[g]=e[g-wt]}}t.l=k,t.p=xt,t.b=g,t.f=u,k&&(u=1,t.m=p,t.d=v,t.n=w)}while(!u);return g!=e.length&&o?lo(e,0,g):e.subarray(0,g)},fo=new St(0),uo=function(n,t){return((n[0]&15)!=8||n[0]>>4>7||(n[0]<<8|n[1])%31)&&Ut(6,"invalid zlib data"),(n[1]>>5&1)==+!t&&Ut(6,"invalid zlib data: "+(n[1]&32?"need":"unexpected")+" dictionary"),(n[1]>>3&4)+2};po=typeof TextDecoder<"u"&&new TextDecoder,mo=0;try{po.decode(fo,{stream:!0}),mo=1}catch{}});var Xi={};ys(Xi,{default:()=>$o});function yo(){let n=new ArrayBuffer(4),t=new Float32Array(n),e=new Uint32Array(n),i=new Uint32Array(512),r=new Uint32Array(512);for(let l=0;l<256;++l){let h=l-127;h<-27?(i[l]=0,i[l|256]=32768,r[l]=24,r[l|256]=24):h<-14?(i[l]=1024>>-h-14,i[l|256]=1024>>-h-14|32768,r[l]=-h-1,r[l|256]=-h-1):h<=15?(i[l]=h+15<<10,i[l|256]=h+15<<10|32768,r[l]=13,r[l|256]=13):h<128?(i[l]=31744,i[l|256]=64512,r[l]=24,r[l|256]=24):(i[l]=31744,i[l|256]=64512,r[l]=13,r[l|256]=13)}let s=new Uint32Array(2048),o=new Uint32Array(64),c=new Uint32Array(64);for(let l=1;l<1024;++l){let h=l<<13,u=0;for(;(h&8388608)===0;)h<<=1,u-=8388608;h&=-8388609,u+=947912704,s[l]=h|u}for(let l=1024;l<2048;++l)s[l]=939524096+(l-1024<<13);for(let l=1;l<31;++l)o[l]=l<<23;o[31]=1199570944,o[32]=2147483648;for(let l=33;l<63;++l)o[l]=2147483648+(l-32<<23);o[63]=3347054592;for(let l=1;l<64;++l)l!==32&&(c[l]=1024);return{floatView:t,uint32View:e,baseTable:i,shiftTable:r,mantissaTable:s,exponentTable:o,offsetTable:c}}function bo(n,t=Je){let J=Math.pow(2.7182818,2.2);function O(a,f){let m=0;for(let M=0;M<65536;++M)(M==0||a[M>>3]&1<<(M&7))&&(f[m++]=M);let x=m-1;for(;m<65536;)f[m++]=0;return x}function D(a){for(let f=0;f<16384;f++)a[f]={},a[f].len=0,a[f].lit=0,a[f].p=null}let Z={l:0,c:0,lc:0};function V(a,f,m,x,M){for(;m<a;)f=f<<8|Dn(x,M),m+=8;m-=a,Z.l=f>>m&(1<<a)-1,Z.c=f,Z.lc=m}let rt=new Array(59);function nt(a){for(let m=0;m<=58;++m)rt[m]=0;for(let m=0;m<65537;++m)rt[a[m]]+=1;let f=0;for(let m=58;m>0;--m){let x=f+rt[m]>>1;rt[m]=f,f=x}for(let m=0;m<65537;++m){let x=a[m];x>0&&(a[m]=x|rt[x]++<<6)}}function X(a,f,m,x,M,y){let z=f,E=0,U=0;for(;x<=M;x++){if(z.value-f.value>m)return!1;V(6,E,U,a,z);let S=Z.l;if(E=Z.c,U=Z.lc,y[x]=S,S==63){if(z.value-f.value>m)throw new Error("Something wrong with hufUnpackEncTable");V(8,E,U,a,z);let _=Z.l+6;if(E=Z.c,U=Z.lc,x+_>M+1)throw new Error("Something wrong with hufUnpackEncTable");for(;_--;)y[x++]=0;x--}else if(S>=59){let _=S-59+2;if(x+_>M+1)throw new Error("Something wrong with hufUnpackEncTable");for(;_--;)y[x++]=0;x--}}nt(y)}function vt(a){return a&63}function Et(a){return a>>6}function wt(a,f,m,x){for(;f<=m;f++){let M=Et(a[f]),y=vt(a[f]);if(M>>y)throw new Error("Invalid table entry");if(y>14){let z=x[M>>y-14];if(z.len)throw new Error("Invalid table entry");if(z.lit++,z.p){let E=z.p;z.p=new Array(z.lit);for(let U=0;U<z.lit-1;++U)z.p[U]=E[U]}else z.p=new Array(1);z.p[z.lit-1]=f}else if(y){let z=0;for(let E=1<<14-y;E>0;E--){let U=x[(M<<14-y)+z];if(U.len||U.p)throw new Error("Invalid table entry");U.len=y,U.lit=f,z++}}}return!0}let kt={c:0,lc:0};function Dt(a,f,m,x){a=a<<8|Dn(m,x),f+=8,kt.c=a,kt.lc=f}let xt={c:0,lc:0};function ft(a,f,m,x,M,y,z,E,U){if(a==f){x<8&&(Dt(m,x,M,y),m=kt.c,x=kt.lc),x-=8;let S=m>>x;if(S=new Uint8Array([S])[0],E.value+S>U)return!1;let _=z[E.value-1];for(;S-- >0;)z[E.value++]=_}else if(E.value<U)z[E.value++]=a;else return!1;xt.c=m,xt.lc=x}function It(a){return a&65535}function Ht(a){let f=It(a);return f>32767?f-65536:f}let tt={a:0,b:0};function Ct(a,f){let m=Ht(a),M=Ht(f),y=m+(M&1)+(M>>1),z=y,E=y-M;tt.a=z,tt.b=E}function Nt(a,f){let m=It(a),x=It(f),M=m-(x>>1)&65535,y=x+M-32768&65535;tt.a=y,tt.b=M}function Pe(a,f,m,x,M,y,z){let E=z<16384,U=m>M?M:m,S=1,_,C;for(;S<=U;)S<<=1;for(S>>=1,_=S,S>>=1;S>=1;){C=0;let F=C+y*(M-_),P=y*S,H=y*_,N=x*S,R=x*_,q,et,at,bt;for(;C<=F;C+=H){let st=C,j=C+x*(m-_);for(;st<=j;st+=R){let ht=st+N,_t=st+P,ut=_t+N;E?(Ct(a[st+f],a[_t+f]),q=tt.a,at=tt.b,Ct(a[ht+f],a[ut+f]),et=tt.a,bt=tt.b,Ct(q,et),a[st+f]=tt.a,a[ht+f]=tt.b,Ct(at,bt),a[_t+f]=tt.a,a[ut+f]=tt.b):(Nt(a[st+f],a[_t+f]),q=tt.a,at=tt.b,Nt(a[ht+f],a[ut+f]),et=tt.a,bt=tt.b,Nt(q,et),a[st+f]=tt.a,a[ht+f]=tt.b,Nt(at,bt),a[_t+f]=tt.a,a[ut+f]=tt.b)}if(m&S){let ht=st+P;E?Ct(a[st+f],a[ht+f]):Nt(a[st+f],a[ht+f]),q=tt.a,a[ht+f]=tt.b,a[st+f]=q}}if(M&S){let st=C,j=C+x*(m-_);for(;st<=j;st+=R){let ht=st+N;E?Ct(a[st+f],a[ht+f]):Nt(a[st+f],a[ht+f]),q=tt.a,a[ht+f]=tt.b,a[st+f]=q}}_=S,S>>=1}return C}function rn(a,f,m,x,M,y,z,E,U){let S=0,_=0,C=z,F=Math.trunc(x.value+(M+7)/8);for(;x.value<F;)for(Dt(S,_,m,x),S=kt.c,_=kt.lc;_>=14;){let H=S>>_-14&16383,N=f[H];if(N.len)_-=N.len,ft(N.lit,y,S,_,m,x,E,U,C),S=xt.c,_=xt.lc;else{if(!N.p)throw new Error("hufDecode issues");let R;for(R=0;R<N.lit;R++){let q=vt(a[N.p[R]]);for(;_<q&&x.value<F;)Dt(S,_,m,x),S=kt.c,_=kt.lc;if(_>=q&&Et(a[N.p[R]])==(S>>_-q&(1<<q)-1)){_-=q,ft(N.p[R],y,S,_,m,x,E,U,C),S=xt.c,_=xt.lc;break}}if(R==N.lit)throw new Error("hufDecode issues")}}let P=8-M&7;for(S>>=P,_-=P;_>0;){let H=f[S<<14-_&16383];if(H.len)_-=H.len,ft(H.lit,y,S,_,m,x,E,U,C),S=xt.c,_=xt.lc;else throw new Error("hufDecode issues")}return!0}function ue(a,f,m,x,M,y){let z={value:0},E=m.value,U=At(f,m),S=At(f,m);m.value+=4;let _=At(f,m);if(m.value+=4,U<0||U>=65537||S<0||S>=65537)throw new Error("Something wrong with HUF_ENCSIZE");let C=new Array(65537),F=new Array(16384);D(F);let P=x-(m.value-E);if(X(a,m,P,U,S,C),_>8*(x-(m.value-E)))throw new Error("Something wrong with hufUncompress");wt(C,U,S,F),rn(C,F,a,m,_,S,y,M,z)}function Ne(a,f,m){for(let x=0;x<m;++x)f[x]=a[f[x]]}function pe(a){for(let f=1;f<a.length;f++){let m=a[f-1]+a[f]-128;a[f]=m}}function Fn(a,f){let m=0,x=Math.floor((a.length+1)/2),M=0,y=a.length-1;for(;!(M>y||(f[M++]=a[m++],M>y));)f[M++]=a[x++]}function Bn(a){let f=a.byteLength,m=new Array,x=0,M=new DataView(a);for(;f>0;){let y=M.getInt8(x++);if(y<0){let z=-y;f-=z+1;for(let E=0;E<z;E++)m.push(M.getUint8(x++))}else{let z=y;f-=2;let E=M.getUint8(x++);for(let U=0;U<z+1;U++)m.push(E)}}return m}function Dr(a,f,m,x,M,y){let z=new DataView(y.buffer),E=m[a.idx[0]].width,U=m[a.idx[0]].height,S=3,_=Math.floor(E/8),C=Math.ceil(E/8),F=Math.ceil(U/8),P=E-(C-1)*8,H=U-(F-1)*8,N={value:0},R=new Array(S),q=new Array(S),et=new Array(S),at=new Array(S),bt=new Array(S);for(let j=0;j<S;++j)bt[j]=f[a.idx[j]],R[j]=j<1?0:R[j-1]+C*F,q[j]=new Float32Array(64),et[j]=new Uint16Array(64),at[j]=new Uint16Array(C*64);for(let j=0;j<F;++j){let ht=8;j==F-1&&(ht=H);let _t=8;for(let Q=0;Q<C;++Q){Q==C-1&&(_t=P);for(let it=0;it<S;++it)et[it].fill(0),et[it][0]=M[R[it]++],Hr(N,x,et[it]),Gr(et[it],q[it]),qr(q[it]);S==3&&Zr(q);for(let it=0;it<S;++it)Wr(q[it],at[it],Q*64)}let ut=0;for(let Q=0;Q<S;++Q){let it=m[a.idx[Q]].type;for(let Lt=8*j;Lt<8*j+ht;++Lt){ut=bt[Q][Lt];for(let me=0;me<_;++me){let Ot=me*64+(Lt&7)*8;z.setUint16(ut+0*it,at[Q][Ot+0],!0),z.setUint16(ut+2*it,at[Q][Ot+1],!0),z.setUint16(ut+4*it,at[Q][Ot+2],!0),z.setUint16(ut+6*it,at[Q][Ot+3],!0),z.setUint16(ut+8*it,at[Q][Ot+4],!0),z.setUint16(ut+10*it,at[Q][Ot+5],!0),z.setUint16(ut+12*it,at[Q][Ot+6],!0),z.setUint16(ut+14*it,at[Q][Ot+7],!0),ut+=16*it}}if(_!=C)for(let Lt=8*j;Lt<8*j+ht;++Lt){let me=bt[Q][Lt]+8*_*2*it,Ot=_*64+(Lt&7)*8;for(let Fe=0;Fe<_t;++Fe)z.setUint16(me+Fe*2*it,at[Q][Ot+Fe],!0)}}}let st=new Uint16Array(E);z=new DataView(y.buffer);for(let j=0;j<S;++j){m[a.idx[j]].decoded=!0;let ht=m[a.idx[j]].type;if(m[j].type==2)for(let _t=0;_t<U;++_t){let ut=bt[j][_t];for(let Q=0;Q<E;++Q)st[Q]=z.getUint16(ut+Q*2*ht,!0);for(let Q=0;Q<E;++Q)z.setFloat32(ut+Q*2*ht,L(st[Q]),!0)}}}function Hr(a,f,m){let x,M=1;for(;M<64;)x=f[a.value],x==65280?M=64:x>>8==255?M+=x&255:(m[M]=x,M++),a.value++}function Gr(a,f){f[0]=L(a[0]),f[1]=L(a[1]),f[2]=L(a[5]),f[3]=L(a[6]),f[4]=L(a[14]),f[5]=L(a[15]),f[6]=L(a[27]),f[7]=L(a[28]),f[8]=L(a[2]),f[9]=L(a[4]),f[10]=L(a[7]),f[11]=L(a[13]),f[12]=L(a[16]),f[13]=L(a[26]),f[14]=L(a[29]),f[15]=L(a[42]),f[16]=L(a[3]),f[17]=L(a[8]),f[18]=L(a[12]),f[19]=L(a[17]),f[20]=L(a[25]),f[21]=L(a[30]),f[22]=L(a[41]),f[23]=L(a[43]),f[24]=L(a[9]),f[25]=L(a[11]),f[26]=L(a[18]),f[27]=L(a[24]),f[28]=L(a[31]),f[29]=L(a[40]),f[30]=L(a[44]),f[31]=L(a[53]),f[32]=L(a[10]),f[33]=L(a[19]),f[34]=L(a[23]),f[35]=L(a[32]),f[36]=L(a[39]),f[37]=L(a[45]),f[38]=L(a[52]),f[39]=L(a[54]),f[40]=L(a[20]),f[41]=L(a[22]),f[42]=L(a[33]),f[43]=L(a[38]),f[44]=L(a[46]),f[45]=L(a[51]),f[46]=L(a[55]),f[47]=L(a[60]),f[48]=L(a[21]),f[49]=L(a[34]),f[50]=L(a[37]),f[51]=L(a[47]),f[52]=L(a[50]),f[53]=L(a[56]),f[54]=L(a[59]),f[55]=L(a[61]),f[56]=L(a[35]),f[57]=L(a[36]),f[58]=L(a[48]),f[59]=L(a[49]),f[60]=L(a[57]),f[61]=L(a[58]),f[62]=L(a[62]),f[63]=L(a[63])}function qr(a){let f=.5*Math.cos(.7853975),m=.5*Math.cos(3.14159/16),x=.5*Math.cos(3.14159/8),M=.5*Math.cos(3*3.14159/16),y=.5*Math.cos(5*3.14159/16),z=.5*Math.cos(3*3.14159/8),E=.5*Math.cos(7*3.14159/16),U=new Array(4),S=new Array(4),_=new Array(4),C=new Array(4);for(let F=0;F<8;++F){let P=F*8;U[0]=x*a[P+2],U[1]=z*a[P+2],U[2]=x*a[P+6],U[3]=z*a[P+6],S[0]=m*a[P+1]+M*a[P+3]+y*a[P+5]+E*a[P+7],S[1]=M*a[P+1]-E*a[P+3]-m*a[P+5]-y*a[P+7],S[2]=y*a[P+1]-m*a[P+3]+E*a[P+5]+M*a[P+7],S[3]=E*a[P+1]-y*a[P+3]+M*a[P+5]-m*a[P+7],_[0]=f*(a[P+0]+a[P+4]),_[3]=f*(a[P+0]-a[P+4]),_[1]=U[0]+U[3],_[2]=U[1]-U[2],C[0]=_[0]+_[1],C[1]=_[3]+_[2],C[2]=_[3]-_[2],C[3]=_[0]-_[1],a[P+0]=C[0]+S[0],a[P+1]=C[1]+S[1],a[P+2]=C[2]+S[2],a[P+3]=C[3]+S[3],a[P+4]=C[3]-S[3],a[P+5]=C[2]-S[2],a[P+6]=C[1]-S[1],a[P+7]=C[0]-S[0]}for(let F=0;F<8;++F)U[0]=x*a[16+F],U[1]=z*a[16+F],U[2]=x*a[48+F],U[3]=z*a[48+F],S[0]=m*a[8+F]+M*a[24+F]+y*a[40+F]+E*a[56+F],S[1]=M*a[8+F]-E*a[24+F]-m*a[40+F]-y*a[56+F],S[2]=y*a[8+F]-m*a[24+F]+E*a[40+F]+M*a[56+F],S[3]=E*a[8+F]-y*a[24+F]+M*a[40+F]-m*a[56+F],_[0]=f*(a[F]+a[32+F]),_[3]=f*(a[F]-a[32+F]),_[1]=U[0]+U[3],_[2]=U[1]-U[2],C[0]=_[0]+_[1],C[1]=_[3]+_[2],C[2]=_[3]-_[2],C[3]=_[0]-_[1],a[0+F]=C[0]+S[0],a[8+F]=C[1]+S[1],a[16+F]=C[2]+S[2],a[24+F]=C[3]+S[3],a[32+F]=C[3]-S[3],a[40+F]=C[2]-S[2],a[48+F]=C[1]-S[1],a[56+F]=C[0]-S[0]}function Zr(a){for(let f=0;f<64;++f){let m=a[0][f],x=a[1][f],M=a[2][f];a[0][f]=m+1.5747*M,a[1][f]=m-.1873*x-.4682*M,a[2][f]=m+1.8556*x}}function Wr(a,f,m){for(let x=0;x<64;++x)f[m+x]=Qi.toHalfFloat(jr(a[x]))}function jr(a){return a<=1?Math.sign(a)*Math.pow(Math.abs(a),2.2):Math.sign(a)*Math.pow(J,Math.abs(a)-1)}function sn(a){return new DataView(a.array.buffer,a.offset.value,a.size)}function Yr(a){let f=a.viewer.buffer.slice(a.offset.value,a.offset.value+a.size),m=new Uint8Array(Bn(f)),x=new Uint8Array(m.length);return pe(m),Fn(m,x),new DataView(x.buffer)}function on(a){let f=a.array.slice(a.offset.value,a.offset.value+a.size),m=Ue(f),x=new Uint8Array(m.length);return pe(m),Fn(m,x),new DataView(x.buffer)}function Vr(a){let f=a.viewer,m={value:a.offset.value},x=new Uint16Array(a.columns*a.lines*(a.inputChannels.length*a.type)),M=new Uint8Array(8192),y=0,z=new Array(a.inputChannels.length);for(let H=0,N=a.inputChannels.length;H<N;H++)z[H]={},z[H].start=y,z[H].end=z[H].start,z[H].nx=a.columns,z[H].ny=a.lines,z[H].size=a.type,y+=z[H].nx*z[H].ny*z[H].size;let E=de(f,m),U=de(f,m);if(U>=8192)throw new Error("Something is wrong with PIZ_COMPRESSION BITMAP_SIZE");if(E<=U)for(let H=0;H<U-E+1;H++)M[H+E]=Gt(f,m);let S=new Uint16Array(65536),_=O(M,S),C=At(f,m);ue(a.array,f,m,C,x,y);for(let H=0;H<a.inputChannels.length;++H){let N=z[H];for(let R=0;R<z[H].size;++R)Pe(x,N.start+R,N.nx,N.size,N.ny,N.nx*N.size,_)}Ne(S,x,y);let F=0,P=new Uint8Array(x.buffer.byteLength);for(let H=0;H<a.lines;H++)for(let N=0;N<a.inputChannels.length;N++){let R=z[N],q=R.nx*R.size,et=new Uint8Array(x.buffer,R.end*2,q*2);P.set(et,F),F+=q*2,R.end+=q}return new DataView(P.buffer)}function Kr(a){let f=a.array.slice(a.offset.value,a.offset.value+a.size),m=Ue(f),x=a.inputChannels.length*a.lines*a.columns*a.totalBytes,M=new ArrayBuffer(x),y=new DataView(M),z=0,E=0,U=new Array(4);for(let S=0;S<a.lines;S++)for(let _=0;_<a.inputChannels.length;_++){let C=0;switch(a.inputChannels[_].pixelType){case 1:U[0]=z,U[1]=U[0]+a.columns,z=U[1]+a.columns;for(let P=0;P<a.columns;++P){let H=m[U[0]++]<<8|m[U[1]++];C+=H,y.setUint16(E,C,!0),E+=2}break;case 2:U[0]=z,U[1]=U[0]+a.columns,U[2]=U[1]+a.columns,z=U[2]+a.columns;for(let P=0;P<a.columns;++P){let H=m[U[0]++]<<24|m[U[1]++]<<16|m[U[2]++]<<8;C+=H,y.setUint32(E,C,!0),E+=4}break}}return y}function Rn(a){let f=a.viewer,m={value:a.offset.value},x=new Uint8Array(a.columns*a.lines*(a.inputChannels.length*a.type*2)),M={version:yt(f,m),unknownUncompressedSize:yt(f,m),unknownCompressedSize:yt(f,m),acCompressedSize:yt(f,m),dcCompressedSize:yt(f,m),rleCompressedSize:yt(f,m),rleUncompressedSize:yt(f,m),rleRawSize:yt(f,m),totalAcUncompressedCount:yt(f,m),totalDcUncompressedCount:yt(f,m),acCompression:yt(f,m)};if(M.version<2)throw new Error("EXRLoader.parse: "+Kt.compression+" version "+M.version+" is unsupported");let y=new Array,z=de(f,m)-2;for(;z>0;){let N=Le(f.buffer,m),R=Gt(f,m),q=R>>2&3,et=(R>>4)-1,at=new Int8Array([et])[0],bt=Gt(f,m);y.push({name:N,index:at,type:bt,compression:q}),z-=N.length+3}let E=Kt.channels,U=new Array(a.inputChannels.length);for(let N=0;N<a.inputChannels.length;++N){let R=U[N]={},q=E[N];R.name=q.name,R.compression=0,R.decoded=!1,R.type=q.pixelType,R.pLinear=q.pLinear,R.width=a.columns,R.height=a.lines}let S={idx:new Array(3)};for(let N=0;N<a.inputChannels.length;++N){let R=U[N];for(let q=0;q<y.length;++q){let et=y[q];R.name==et.name&&(R.compression=et.compression,et.index>=0&&(S.idx[et.index]=N),R.offset=N)}}let _,C,F;if(M.acCompressedSize>0)switch(M.acCompression){case 0:_=new Uint16Array(M.totalAcUncompressedCount),ue(a.array,f,m,M.acCompressedSize,_,M.totalAcUncompressedCount);break;case 1:let N=a.array.slice(m.value,m.value+M.totalAcUncompressedCount),R=Ue(N);_=new Uint16Array(R.buffer),m.value+=M.totalAcUncompressedCount;break}if(M.dcCompressedSize>0){let N={array:a.array,offset:m,size:M.dcCompressedSize};C=new Uint16Array(on(N).buffer),m.value+=M.dcCompressedSize}if(M.rleRawSize>0){let N=a.array.slice(m.value,m.value+M.rleCompressedSize),R=Ue(N);F=Bn(R.buffer),m.value+=M.rleCompressedSize}let P=0,H=new Array(U.length);for(let N=0;N<H.length;++N)H[N]=new Array;for(let N=0;N<a.lines;++N)for(let R=0;R<U.length;++R)H[R].push(P),P+=U[R].width*a.type*2;Dr(S,H,U,_,C,x);for(let N=0;N<U.length;++N){let R=U[N];if(!R.decoded)switch(R.compression){case 2:let q=0,et=0;for(let at=0;at<a.lines;++at){let bt=H[N][q];for(let st=0;st<R.width;++st){for(let j=0;j<2*R.type;++j)x[bt++]=F[et+j*R.width*R.height];et++}q++}break;default:throw new Error("EXRLoader.parse: unsupported channel compression")}}return new DataView(x.buffer)}function Le(a,f){let m=new Uint8Array(a),x=0;for(;m[f.value+x]!=0;)x+=1;let M=new TextDecoder().decode(m.slice(f.value,f.value+x));return f.value=f.value+x+1,M}function Jr(a,f,m){let x=new TextDecoder().decode(new Uint8Array(a).slice(f.value,f.value+m));return f.value=f.value+m,x}function Qr(a,f){let m=Mt(a,f),x=At(a,f);return[m,x]}function Xr(a,f){let m=At(a,f),x=At(a,f);return[m,x]}function Mt(a,f){let m=a.getInt32(f.value,!0);return f.value=f.value+4,m}function At(a,f){let m=a.getUint32(f.value,!0);return f.value=f.value+4,m}function Dn(a,f){let m=a[f.value];return f.value=f.value+1,m}function Gt(a,f){let m=a.getUint8(f.value);return f.value=f.value+1,m}let yt=function(a,f){let m;return"getBigInt64"in DataView.prototype?m=Number(a.getBigInt64(f.value,!0)):m=a.getUint32(f.value+4,!0)+Number(a.getUint32(f.value,!0)<<32),f.value+=8,m};function dt(a,f){let m=a.getFloat32(f.value,!0);return f.value+=4,m}function ts(a,f){return Qi.toHalfFloat(dt(a,f))}function L(a){let f=(a&31744)>>10,m=a&1023;return(a>>15?-1:1)*(f?f===31?m?NaN:1/0:Math.pow(2,f-15)*(1+m/1024):6103515625e-14*(m/1024))}function de(a,f){let m=a.getUint16(f.value,!0);return f.value+=2,m}function es(a,f){return L(de(a,f))}function ns(a,f,m,x){let M=m.value,y=[];for(;m.value<M+x-1;){let z=Le(f,m),E=Mt(a,m),U=Gt(a,m);m.value+=3;let S=Mt(a,m),_=Mt(a,m);y.push({name:z,pixelType:E,pLinear:U,xSampling:S,ySampling:_})}return m.value+=1,y}function is(a,f){let m=dt(a,f),x=dt(a,f),M=dt(a,f),y=dt(a,f),z=dt(a,f),E=dt(a,f),U=dt(a,f),S=dt(a,f);return{redX:m,redY:x,greenX:M,greenY:y,blueX:z,blueY:E,whiteX:U,whiteY:S}}function rs(a,f){let m=["NO_COMPRESSION","RLE_COMPRESSION","ZIPS_COMPRESSION","ZIP_COMPRESSION","PIZ_COMPRESSION","PXR24_COMPRESSION","B44_COMPRESSION","B44A_COMPRESSION","DWAA_COMPRESSION","DWAB_COMPRESSION"],x=Gt(a,f);return m[x]}function ss(a,f){let m=Mt(a,f),x=Mt(a,f),M=Mt(a,f),y=Mt(a,f);return{xMin:m,yMin:x,xMax:M,yMax:y}}function os(a,f){let m=["INCREASING_Y","DECREASING_Y","RANDOM_Y"],x=Gt(a,f);return m[x]}function as(a,f){let m=["ENVMAP_LATLONG","ENVMAP_CUBE"],x=Gt(a,f);return m[x]}function ls(a,f){let m=["ONE_LEVEL","MIPMAP_LEVELS","RIPMAP_LEVELS"],x=["ROUND_DOWN","ROUND_UP"],M=At(a,f),y=At(a,f),z=Gt(a,f);return{xSize:M,ySize:y,levelMode:m[z&15],roundingMode:x[z>>4]}}function cs(a,f){let m=dt(a,f),x=dt(a,f);return[m,x]}function hs(a,f){let m=dt(a,f),x=dt(a,f),M=dt(a,f);return[m,x,M]}function fs(a,f,m,x,M){if(x==="string"||x==="stringvector"||x==="iccProfile")return Jr(f,m,M);if(x==="chlist")return ns(a,f,m,M);if(x==="chromaticities")return is(a,m);if(x==="compression")return rs(a,m);if(x==="box2i")return ss(a,m);if(x==="envmap")return as(a,m);if(x==="tiledesc")return ls(a,m);if(x==="lineOrder")return os(a,m);if(x==="float")return dt(a,m);if(x==="v2f")return cs(a,m);if(x==="v3f")return hs(a,m);if(x==="int")return Mt(a,m);if(x==="rational")return Qr(a,m);if(x==="timecode")return Xr(a,m);if(x==="preview")return m.value+=M,"skipped";m.value+=M}function us(a,f){let m=Math.log2(a);return f=="ROUND_DOWN"?Math.floor(m):Math.ceil(m)}function ps(a,f,m){let x=0;switch(a.levelMode){case"ONE_LEVEL":x=1;break;case"MIPMAP_LEVELS":x=us(Math.max(f,m),a.roundingMode)+1;break;case"RIPMAP_LEVELS":throw new Error("EXRLoader: RIPMAP_LEVELS tiles currently unsupported.")}return x}function Hn(a,f,m,x){let M=new Array(a);for(let y=0;y<a;y++){let z=1<<y,E=f/z|0;x=="ROUND_UP"&&E*z<f&&(E+=1);let U=Math.max(E,1);M[y]=(U+m-1)/m|0}return M}function ds(a){let f=a.offset,m={value:0};for(let x=0;x<a.tileCount;x++){let M=Mt(a.viewer,f),y=Mt(a.viewer,f);f.value+=8,a.size=At(a.viewer,f);let z=M*a.blockWidth,E=y*a.blockHeight;a.columns=z+a.blockWidth>a.width?a.width-z:a.blockWidth,a.lines=E+a.blockHeight>a.height?a.height-E:a.blockHeight;let U=a.columns*a.totalBytes,_=a.size<a.lines*U?a.uncompress(a):sn(a);f.value+=a.size;for(let C=0;C<a.lines;C++){let F=C*a.columns*a.totalBytes;for(let P=0;P<a.inputChannels.length;P++){let H=Kt.channels[P].name,N=a.channelByteOffsets[H]*a.columns,R=a.decodeChannels[H];if(R===void 0)continue;m.value=F+N;let q=(a.height-(1+E+C))*a.outLineWidth;for(let et=0;et<a.columns;et++){let at=q+(et+z)*a.outputChannels+R;a.byteArray[at]=a.getter(_,m)}}}}}function ms(a){let f=a.offset,m={value:0};for(let x=0;x<a.height/a.blockHeight;x++){let M=Mt(a.viewer,f)-Kt.dataWindow.yMin;a.size=At(a.viewer,f),a.lines=M+a.blockHeight>a.height?a.height-M:a.blockHeight;let y=a.columns*a.totalBytes,E=a.size<a.lines*y?a.uncompress(a):sn(a);f.value+=a.size;for(let U=0;U<a.blockHeight;U++){let S=x*a.blockHeight,_=U+a.scanOrder(S);if(_>=a.height)continue;let C=U*y,F=(a.height-1-_)*a.outLineWidth;for(let P=0;P<a.inputChannels.length;P++){let H=Kt.channels[P].name,N=a.channelByteOffsets[H]*a.columns,R=a.decodeChannels[H];if(R!==void 0){m.value=C+N;for(let q=0;q<a.columns;q++){let et=F+q*a.outputChannels+R;a.byteArray[et]=a.getter(E,m)}}}}}}function gs(a,f,m){let x={};if(a.getUint32(0,!0)!=20000630)throw new Error("EXRLoader: Provided file doesn't appear to be in OpenEXR format.");x.version=a.getUint8(4);let M=a.getUint8(5);x.spec={singleTile:!!(M&2),longName:!!(M&4),deepFormat:!!(M&8),multiPart:!!(M&16)},m.value=8;let y=!0;for(;y;){let z=Le(f,m);if(z==0)y=!1;else{let E=Le(f,m),U=At(a,m),S=fs(a,f,m,E,U);S===void 0?console.warn(`EXRLoader: Skipped unknown header attribute type '${E}'.`):x[z]=S}}if((M&-7)!=0)throw console.error("EXRHeader:",x),new Error("EXRLoader: Provided file is currently unsupported.");return x}function vs(a,f,m,x,M){let y={size:0,viewer:f,array:m,offset:x,width:a.dataWindow.xMax-a.dataWindow.xMin+1,height:a.dataWindow.yMax-a.dataWindow.yMin+1,inputChannels:a.channels,channelByteOffsets:{},scanOrder:null,totalBytes:null,columns:null,lines:null,type:null,uncompress:null,getter:null,format:null,colorSpace:Ji};switch(a.compression){case"NO_COMPRESSION":y.blockHeight=1,y.uncompress=sn;break;case"RLE_COMPRESSION":y.blockHeight=1,y.uncompress=Yr;break;case"ZIPS_COMPRESSION":y.blockHeight=1,y.uncompress=on;break;case"ZIP_COMPRESSION":y.blockHeight=16,y.uncompress=on;break;case"PIZ_COMPRESSION":y.blockHeight=32,y.uncompress=Vr;break;case"PXR24_COMPRESSION":y.blockHeight=16,y.uncompress=Kr;break;case"DWAA_COMPRESSION":y.blockHeight=32,y.uncompress=Rn;break;case"DWAB_COMPRESSION":y.blockHeight=256,y.uncompress=Rn;break;default:throw new Error("EXRLoader.parse: "+a.compression+" is unsupported")}let z={};for(let _ of a.channels)switch(_.name){case"Y":case"R":case"G":case"B":case"A":z[_.name]=!0,y.type=_.pixelType}let E=!1;if(z.R&&z.G&&z.B)E=!z.A,y.outputChannels=4,y.decodeChannels={R:0,G:1,B:2,A:3};else if(z.Y)y.outputChannels=1,y.decodeChannels={Y:0};else throw new Error("EXRLoader.parse: file contains unsupported data channels.");if(y.type==1)switch(M){case Mn:y.getter=es;break;case Je:y.getter=de;break}else if(y.type==2)switch(M){case Mn:y.getter=dt;break;case Je:y.getter=ts}else throw new Error("EXRLoader.parse: unsupported pixelType "+y.type+" for "+a.compression+".");y.columns=y.width;let U=y.width*y.height*y.outputChannels;switch(M){case Mn:y.byteArray=new Float32Array(U),E&&y.byteArray.fill(1,0,U);break;case Je:y.byteArray=new Uint16Array(U),E&&y.byteArray.fill(15360,0,U);break;default:console.error("EXRLoader: unsupported type: ",M);break}let S=0;for(let _ of a.channels)y.decodeChannels[_.name]!==void 0&&(y.channelByteOffsets[_.name]=S),S+=_.pixelType*2;if(y.totalBytes=S,y.outLineWidth=y.width*y.outputChannels,a.lineOrder==="INCREASING_Y"?y.scanOrder=_=>_:y.scanOrder=_=>y.height-1-_,y.outputChannels==4?(y.format=vo,y.colorSpace=Ji):(y.format=xo,y.colorSpace=wo),a.spec.singleTile){y.blockHeight=a.tiles.ySize,y.blockWidth=a.tiles.xSize;let _=ps(a.tiles,y.width,y.height),C=Hn(_,y.width,a.tiles.xSize,a.tiles.roundingMode),F=Hn(_,y.height,a.tiles.ySize,a.tiles.roundingMode);y.tileCount=C[0]*F[0];for(let P=0;P<_;P++)for(let H=0;H<F[P];H++)for(let N=0;N<C[P];N++)yt(f,x);y.decode=ds.bind(y)}else{y.blockWidth=y.width;let _=Math.ceil(y.height/y.blockHeight);for(let C=0;C<_;C++)yt(f,x);y.decode=ms.bind(y)}return y}let Gn={value:0},qn=new DataView(n),xs=new Uint8Array(n),Kt=gs(qn,n,Gn),Jt=vs(Kt,qn,xs,Gn,t);return Jt.decode(Jt),{header:Kt,width:Jt.width,height:Jt.height,data:Jt.byteArray,format:Jt.format,colorSpace:Jt.colorSpace}}var Mn,Je,vo,xo,wo,Ji,Qe,Qi,$o,tr=Zn(()=>{Ki();Mn=1015,Je=1016,vo=1023,xo=1028,wo="",Ji="srgb-linear",Qe=yo();Qi={toHalfFloat(n){Math.abs(n)>65504&&console.warn("DataUtils.toHalfFloat(): Value out of range."),n=Math.max(-65504,Math.min(n,65504)),Qe.floatView[0]=n;let t=Qe.uint32View[0],e=t>>23&511;return Qe.baseTable[e]+((t&8388607)>>Qe.shiftTable[e])}};$o=bo});var Wn=`.page{color-scheme:dark;--bg:#141415;--panel:#1c1c1e;--raise:#27272a;--well:#111112;--line:#323236;--edge:#6e6e76;--text:#ededef;--dim:#a8a8b0;--a:#6ea8ff;--b:#ffae57;--warn:#ff8f85;--ok:#7fd1a0;--focus:#8ab8ff;--knob:#f4f4f5;--track:#47474d;--air:#232326;--cut1:#3a4652;--kw:#9cc3ff;--ty:#e5b8ff;--nu:#ffc48a;--co:#95959d}
.page[data-t=light]{color-scheme:light;--bg:#e9e9eb;--panel:#fbfbfc;--raise:#ececef;--well:#fff;--line:#d9d9de;--edge:#7d7d86;--text:#17171a;--dim:#5b5b64;--a:#1559c7;--b:#a34a00;--warn:#b3261e;--ok:#1c6b3f;--focus:#1559c7;--knob:#fff;--track:#c3c3ca;--air:#f0f0f2;--cut1:#cfdde8;--kw:#1559c7;--ty:#7a2fa6;--nu:#974300;--co:#65656e}
*{box-sizing:border-box;margin:0}
.page{background:var(--bg);color:var(--text);font:13px/1.4 Inter,-apple-system,"Segoe UI",Roboto,"Liberation Sans",Arial,sans-serif;font-variant-numeric:tabular-nums;-webkit-text-size-adjust:100%}
button,input,select,textarea{font:inherit;color:inherit;font-variant-numeric:inherit}
button{background:none;border:0;cursor:pointer}
code,pre,.m{font-family:ui-monospace,"SF Mono",Menlo,Consolas,"Liberation Mono",monospace;font-size:12px}
:focus-visible{outline:2px solid var(--focus);outline-offset:2px;border-radius:4px}
.dim{color:var(--dim)}
.s{font-size:12px}
.xs{font-size:11px;line-height:1.35}
svg text{font:11px Inter,-apple-system,"Segoe UI",Roboto,"Liberation Sans",Arial,sans-serif;fill:var(--dim)}
.sr{position:absolute;width:1px;height:1px;overflow:hidden;clip-path:inset(50%)}
.app{height:100vh;height:100dvh;min-height:600px;display:grid;grid:52px 1fr 56px 232px/minmax(0,1fr) 364px;grid-template-areas:"top top" "stage side" "light side" "dock side"}
.top{grid-area:top;display:flex;align-items:center;gap:8px;padding:0 12px;background:var(--panel);border-bottom:1px solid var(--line)}
.logo{font-weight:650;font-size:15px;letter-spacing:-.01em;margin-right:8px}
.logo span{color:var(--dim);font-weight:400}
.chip{display:flex;align-items:center;gap:8px;height:36px;padding:0 10px 0 6px;border:1px solid var(--line);border-radius:8px;text-align:left;min-width:0}
.chip:hover,.btn:hover,.ib:hover{background:var(--raise)}
.chip>b,.k{flex:none;display:grid;place-items:center;width:22px;height:22px;border-radius:5px;font-size:12px;font-weight:700;color:var(--panel);background:var(--a)}
.B>b,.k.kb{background:var(--b)}
.chip span{min-width:0;display:block;line-height:1.2}
.chip span *{display:block;white-space:nowrap;overflow:hidden;text-overflow:ellipsis}
.chip small{font-size:11px;color:var(--dim)}
.sp{flex:1}
.seg{display:flex;padding:2px;border-radius:8px;background:var(--raise);flex:none}
.seg button{height:26px;padding:0 10px;border-radius:6px;font-size:12px;color:var(--dim);white-space:nowrap}
.seg button:hover{color:var(--text)}
.seg [aria-selected=true],.seg [aria-pressed=true]{background:var(--panel);color:var(--text);box-shadow:0 0 0 1px var(--line);font-weight:600}
.btn{height:30px;padding:0 10px;border-radius:7px;border:1px solid var(--line);font-size:12px;white-space:nowrap}
.ib{width:30px;height:30px;border-radius:7px;display:grid;place-items:center;color:var(--dim);flex:none}
.ib:hover{color:var(--text)}
.ib svg,.ic{width:16px;height:16px;fill:none;stroke:currentColor;stroke-width:1.5;stroke-linecap:round;stroke-linejoin:round}
.stage{grid-area:stage;position:relative;overflow:hidden;background:#3b3b3b;min-height:0;--w:50%;color:#f4f4f5;--focus:#fff}
@keyframes fl{50%{opacity:0}
}
.glass{position:absolute;background:rgba(20,20,21,.93);border-radius:9px;box-shadow:0 0 0 1px rgba(255,255,255,.1);color:#f1f1f3}
.glass .dim{color:#b6b6bd}
.views{left:12px;top:12px;display:flex;padding:2px}
.views button{height:26px;padding:0 10px;border-radius:7px;font-size:12px;color:#b6b6bd}
.views button:hover{color:#fff}
.views [aria-selected=true]{background:#f1f1f3;color:#17171a;font-weight:600}
.qual{right:12px;top:12px;display:flex;gap:12px;align-items:center;height:30px;padding:0 12px;font-size:12px}
.qual i{width:40px;height:3px;border-radius:2px;background:linear-gradient(90deg,#f1f1f3 100%,#555 0)}
.qual b{font-weight:600}
.wipe{position:absolute;top:0;bottom:0;left:var(--w);width:32px;margin-left:-16px;cursor:ew-resize;touch-action:none}
.wipe:before{content:"";position:absolute;left:15px;top:0;bottom:0;width:2px;background:#fff;box-shadow:0 0 0 1px rgba(0,0,0,.35)}
.wipe i{position:absolute;left:2px;top:calc(50% + 116px);width:28px;height:28px;margin-top:-14px;border-radius:50%;background:#fff;color:#17171a;display:grid;place-items:center;box-shadow:0 1px 4px rgba(0,0,0,.5)}
.wipe:focus-visible{outline:0}
.wipe:focus-visible i{box-shadow:0 0 0 2px #17171a,0 0 0 5px #8ab8ff}
.tag{position:absolute;bottom:12px;display:flex;gap:8px;align-items:center;font-size:12px;padding:4px 10px 4px 4px;border-radius:9px;white-space:nowrap}
.tag.A{right:calc(100% - var(--w) + 14px)}
.tag.B{left:calc(var(--w) + 14px)}
.stage .k{background:#6ea8ff;color:#141415}
.stage .k.kb{background:#ffae57}
.probe{right:12px;top:54px;width:252px;padding:12px}
.probe table{border-collapse:collapse;width:100%;font-size:12px}
.probe td,.probe th{padding:2px 0;text-align:right;font-weight:400}
.probe td:first-child,.probe th:first-child{text-align:left;color:#b6b6bd}
.probe h3{font-size:12px;font-weight:600;display:flex;gap:6px;align-items:center;margin-bottom:6px}
.probe hr{border:0;border-top:1px solid #ffffff22;margin:6px 0}
.hair{position:absolute;width:20px;height:20px;margin:-10px;left:45.5%;top:48.5%;border:1.5px solid #fff;border-radius:50%;box-shadow:0 0 0 1px #0009,inset 0 0 0 1px #0009}
.hair:after{content:"";position:absolute;left:8px;top:8px;width:1.5px;height:1.5px;background:#fff}
.cmp{left:12px;bottom:12px;padding:8px 12px;display:grid;grid:auto auto/auto auto auto;column-gap:16px;font-size:12px}
.cmp span{font-size:11px}
.keys{right:12px;bottom:12px;padding:0 10px;height:28px;display:flex;gap:12px;align-items:center;font-size:11px}
kbd{font:600 11px ui-monospace,"Liberation Mono",monospace;border:1px solid currentColor;border-radius:4px;padding:0 4px;margin-right:4px;opacity:.9}
.light{grid-area:light;display:flex;align-items:center;gap:16px;padding:0 12px;background:var(--panel);border-top:1px solid var(--line);min-width:0}
.light label,.lb{display:block;font-size:11px;color:var(--dim);line-height:1;margin-bottom:6px;white-space:nowrap}
.light label b,.lb b{font-weight:500;color:var(--text);margin-left:6px}
.envs{display:flex;gap:6px}
.envs button{width:58px;height:32px;border-radius:6px;overflow:hidden;position:relative;padding:0;background-size:cover;background-position:50% 40%;box-shadow:inset 0 0 0 1px #0006}
.envs button span{position:absolute;left:0;right:0;bottom:0;font-size:10px;line-height:13px;color:#fff;background:#000b;text-align:center}
.envs [aria-pressed=true]{outline:2px solid var(--text);outline-offset:1px}
.envs .drop{border:1px dashed var(--edge);color:var(--dim);font-size:11px;box-shadow:none;line-height:1.15}
.light .g{flex:1;min-width:72px;max-width:170px}
.sw{display:flex;align-items:center;gap:8px;font-size:12px;height:32px;white-space:nowrap}
.sw i{width:28px;height:16px;border-radius:8px;background:var(--track);position:relative;flex:none}
.sw i:after{content:"";position:absolute;left:2px;top:2px;width:12px;height:12px;border-radius:50%;background:var(--knob)}
.sw[aria-checked=true] i{background:var(--focus)}
.sw[aria-checked=true] i:after{left:14px}
select{appearance:none;height:26px;border:1px solid var(--line);border-radius:6px;background:var(--well) url("data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' width='8' height='5'%3E%3Cpath d='M0 0h8L4 5z' fill='%23888890'/%3E%3C/svg%3E") no-repeat right 8px center;padding:0 20px 0 8px;font-size:12px;min-width:0;width:100%;text-overflow:ellipsis}
input[type=range]{appearance:none;width:100%;height:18px;background:none;display:block;margin:0;--f:50%}
input[type=range]::-webkit-slider-runnable-track{height:4px;border-radius:2px;background:linear-gradient(90deg,var(--dim) var(--f),var(--track) 0)}
input[type=range]::-webkit-slider-thumb{appearance:none;width:14px;height:14px;margin-top:-5px;border-radius:50%;background:var(--knob);border:1px solid var(--edge);box-shadow:0 1px 2px #0004}
input[type=range]::-moz-range-track{height:4px;border-radius:2px;background:linear-gradient(90deg,var(--dim) var(--f),var(--track) 0)}
input[type=range]::-moz-range-thumb{width:12px;height:12px;border-radius:50%;background:var(--knob);border:1px solid var(--edge)}
input[type=range].bi::-webkit-slider-runnable-track{background:linear-gradient(90deg,var(--track) calc(50% - 1px),var(--text) 0,var(--text) calc(50% + 1px),var(--track) 0)}
input[type=range].beer::-webkit-slider-runnable-track{height:12px;border-radius:4px;background:var(--g);box-shadow:inset 0 0 0 1px #0005}
input[type=range].beer::-webkit-slider-thumb{margin-top:-2px;height:16px;width:8px;border-radius:4px}
.n{width:100%;height:26px;border:1px solid var(--line);border-radius:6px;background:var(--well);text-align:right;padding:0 8px;font-size:12px}
.n:hover,select:hover{border-color:var(--edge)}
.dock{grid-area:dock;display:flex;flex-direction:column;background:var(--panel);border-top:1px solid var(--line);min-height:0}
.tabs{display:flex;align-items:center;gap:4px;padding:0 12px;height:36px;flex:none}
.tabs>[role=tab]{height:36px;padding:0 8px;font-size:12px;color:var(--dim);border-bottom:2px solid transparent}
.tabs>[aria-selected=true]{color:var(--text);border-color:var(--text);font-weight:600}
.tabs>[role=tab]:hover{color:var(--text)}
.pane{flex:1;min-height:0;padding:4px 12px 12px;overflow:auto}
.app:not([data-d=plots]){grid-template-rows:52px 1fr 56px 320px}
.app:not([data-d=plots]) .lg{display:none}
.app:not([data-d=plots]) .stage img{object-position:50% 50%}
.app:has(#furn[aria-checked=true]) .envs{opacity:.45}
.plots{display:grid;grid-template-rows:minmax(0,1fr);grid-template-columns:1fr 1.25fr .9fr;gap:24px;overflow:hidden;height:100%}
.plots figure{min-width:0;display:flex;flex-direction:column;height:100%}
figcaption{display:flex;align-items:center;gap:8px;font-size:12px;font-weight:600;line-height:20px;white-space:nowrap}
figcaption span{font-weight:400;color:var(--dim);font-size:11px;overflow:hidden;text-overflow:ellipsis}
figcaption .ib{width:20px;height:20px;margin-left:auto}
figcaption .ib svg{width:12px;height:12px}
.plots svg.p{flex:1;min-height:0;width:100%;display:block}
.pane.code{display:grid;grid-template-columns:minmax(0,1fr);grid-template-rows:auto 1fr auto;gap:8px}
.code pre{background:var(--well);border:1px solid var(--line);border-radius:8px;padding:10px 12px;overflow:auto;line-height:1.5}
.code pre::-webkit-scrollbar,.pane::-webkit-scrollbar,.side::-webkit-scrollbar{width:8px;height:8px}
.code pre::-webkit-scrollbar-thumb,.pane::-webkit-scrollbar-thumb,.side::-webkit-scrollbar-thumb{background:var(--track);border-radius:4px}
pre i{font-style:normal}
.kw{color:var(--kw)}
.ty{color:var(--ty)}
.nu{color:var(--nu)}
.co{color:var(--co)}
.row{display:flex;align-items:center;gap:8px}
.cmd{display:flex;align-items:center;gap:8px;min-width:0}
.cmd code{flex:1;min-width:0;overflow:hidden;text-overflow:ellipsis;white-space:nowrap;background:var(--raise);border-radius:6px;padding:5px 10px}
.about{display:grid;grid-template-columns:1fr 1fr 1.2fr;gap:32px}
.about h3{font-size:12px;font-weight:600;margin:4px 0 6px}
.about p,.about li{font-size:12px;line-height:1.5;color:var(--dim)}
.about p+p{margin-top:8px}
.about ul{padding-left:14px}
.about li+li{margin-top:4px}
.about li::marker{color:var(--warn)}
.about .y li::marker{color:var(--ok);content:"✓  "}
.side{grid-area:side;background:var(--panel);border-left:1px solid var(--line);overflow:auto;min-height:0}
.sec{padding:12px 16px;border-bottom:1px solid var(--line)}
.side>.sec:first-child{position:sticky;top:0;z-index:2;background:var(--panel)}
.hd{display:flex;align-items:center;gap:8px;min-height:28px}
.hd h2{font-size:13px;font-weight:600}
.stack{position:relative;margin-top:8px;display:grid;gap:0;border-radius:8px;overflow:hidden;border:1px solid var(--line)}
.lay{display:grid;grid-template-columns:72px 1fr auto auto;align-items:center;height:50px;text-align:left;position:relative;background:var(--panel)}
.lay:before{content:"";position:absolute;left:72px;right:0;top:0;border-top:1px solid var(--line)}
.lay.l1:before{display:none}
.lay>svg{width:72px;height:50px;display:block}
.lay>button{text-align:left;padding:0 8px 0 12px;height:50px;min-width:0;line-height:1.3}
.lay b{font-weight:600;display:block;white-space:nowrap}
.lay small{font-size:11px;color:var(--dim);display:block;white-space:nowrap;overflow:hidden;text-overflow:ellipsis}
.lay[data-on]{background:var(--raise)}
.lay[data-on]:after{content:"";position:absolute;left:72px;top:0;bottom:0;width:3px;background:var(--text)}
.lay .ib{width:26px}
.lay>:last-child{margin-right:6px}
.stack :focus-visible{outline-offset:-2px}
.path{font-size:11px;color:var(--dim);margin-top:2px}
.prm{display:grid;grid-template-columns:84px minmax(0,1fr) 76px 16px;gap:2px 8px;align-items:center;margin-top:8px}
.prm>label{font-size:12px;line-height:1.2;align-self:start;padding-top:5px}
.prm>label:has(small){padding-top:0}
.prm>label small{display:block;color:var(--dim);font-size:11px}
.rs{align-self:start;width:16px;height:26px;color:var(--dim);padding:0;display:grid;place-items:center}
.rs svg{width:12px;height:12px}
.rs:hover{color:var(--text)}
.prm>.c{align-self:center}
.wide{grid-column:2/4}
.tick{grid-column:2;position:relative;height:12px;font-size:10px;color:var(--dim);line-height:1;margin:-2px 7px 2px}
.tick span{position:absolute;transform:translateX(-50%)}
.tri{display:grid;grid-template-columns:repeat(3,1fr);gap:6px}
.tri span{position:relative}
.tri .n{padding-left:18px}
.tri span:before{content:attr(data-c);position:absolute;left:7px;top:5px;font-size:11px;font-weight:600;color:var(--dim)}
.hint{grid-column:2/4;font-size:11px;color:var(--dim);line-height:1.35}
.opt{display:grid;grid-template-columns:112px minmax(0,1fr) 16px;gap:4px 8px;align-items:center;margin-top:8px;font-size:12px}
.opt .ch{font-weight:600}
.diffdot{display:inline-block;width:6px;height:6px;border-radius:50%;background:var(--b);margin-left:6px;vertical-align:1px}
[hidden]{display:none!important}
.sv{height:92px;border-radius:6px;position:relative;background:linear-gradient(0deg,#000,transparent),linear-gradient(90deg,#fff,hsl(26 100% 50%));box-shadow:inset 0 0 0 1px #0004}
.sv i{position:absolute;width:12px;height:12px;margin:-6px;border-radius:50%;border:2px solid #fff;box-shadow:0 0 0 1px #0009;left:30%;top:6%}
.hue{height:10px;border-radius:5px;margin:8px 0;background:linear-gradient(90deg,red,#ff0,#0f0,#0ff,#00f,#f0f,red);position:relative;box-shadow:inset 0 0 0 1px #0004}
.hue i{position:absolute;left:7.5%;top:-2px;width:8px;height:14px;margin-left:-4px;border-radius:4px;background:#fff;border:1px solid #555}
.swt{width:26px;height:26px;border-radius:6px;box-shadow:inset 0 0 0 1px #0005;flex:none}
.ptabs{display:none}
.note{display:grid;grid-template-columns:16px 1fr;gap:10px;padding:12px;border-radius:8px;background:var(--raise);font-size:12px}
.note+.note{margin-top:8px}
.note p{color:var(--dim);margin-top:2px}
.note .ic{color:var(--warn);margin-top:1px}
.note.i .ic{color:var(--dim)}
.note .row{margin-top:8px}
.pop{border:1px solid var(--line);border-radius:8px;overflow:hidden}
.pop div{display:grid;grid-template-columns:16px 1fr;gap:8px;padding:7px 10px;font-size:12px}
.pop div+div{border-top:1px solid var(--line)}
.pop .off{color:var(--dim);background:var(--raise)}
.pop input{width:14px;height:14px;margin:1px 0 0;accent-color:var(--focus)}
.offp>:not(.hint){opacity:.55}
.pop .off p{margin-top:2px}
.ktab{width:100%;font-size:12px;border-collapse:collapse}
.ktab td{padding:3px 0}
.ktab td:first-child{width:96px}
@media(max-width:1180px){.app{grid-template-columns:minmax(0,1fr) 316px;grid-template-rows:52px 1fr 56px 216px}
.chip{max-width:172px}
.top .btn.t{display:none}
.light .g.h,.light .h,.keys,figcaption span{display:none}
.plots{gap:16px;grid-template-columns:1fr 1.2fr .85fr}
.light{gap:12px}
.envs button{width:46px}
.sec{padding:12px}
.prm{grid-template-columns:72px minmax(0,1fr) 72px 14px}
.probe{width:204px;padding:10px}
.probe table:first-of-type,.probe hr,.probe .xs{display:none}
.probe td,.probe th{font-size:11px}
.logo span{display:none}
.qual .h,.cmp .h{display:none}
.cmp{grid:auto/auto auto;column-gap:8px}
.tick span:nth-child(2n){display:none}
.seg button{padding:0 8px}
.about{gap:20px}
}
@media(max-width:1180px) and (min-width:641px){.wipe i{top:calc(50% + 96px)}
}
@media(max-width:640px){.page{font-size:14px}
.chip{gap:6px;padding:0 4px}
.wipe:before{top:52px}
.app{height:auto;min-height:100dvh;display:block;padding-bottom:56px}
.top{position:sticky;top:0;z-index:6;height:52px;gap:6px}
.logo,.top .seg,.top .u,.top .sp{display:none}
.chip{flex:1 1 0;max-width:none}
.stage{position:sticky;top:52px;z-index:5;height:318px}
.views{left:8px;top:8px;right:8px;overflow-x:auto;scrollbar-width:none;-webkit-mask:linear-gradient(90deg,#000 88%,#0000)}
.views button{flex:none;height:32px}
.qual{top:auto;bottom:8px;right:8px;height:28px;padding:0 10px;gap:8px}
.qual i,.qual .h,.tag.A span,.tag.B span,.keys,.cmp,.probe{display:none}
.tag{padding:4px}
.tag.A{right:auto;left:8px;bottom:8px}
.tag.B{left:42px;bottom:8px}
.wipe i{top:50%;width:36px;height:36px;left:-2px;margin-top:-18px}
.hair{display:none}
.side>.sec:first-child{position:static}
.side,.dock{border:0}
.side,.light,.dock{display:none}
.app[data-p=side] .side,.app[data-p=dock] .dock{display:block}
.app[data-p=light] .light{display:flex;flex-wrap:wrap;padding:16px;gap:16px;height:auto;border:0}
.light>*{flex:1 1 44%!important;max-width:none!important}
.light .w{flex-basis:100%!important}
.light .h,.light .g.h{display:block}
.envs{flex-wrap:wrap}
.envs button{flex:1 1 30%;height:56px}
.pane{padding:8px 16px 24px}
.tabs{display:none}
.plots,.about{display:block}
.plots figure{height:auto;margin-bottom:20px}
.about>div+div{margin-top:20px}
.plots svg.p{height:220px}
.code pre{max-height:380px}
.code .row{flex-wrap:wrap}
.code .seg{overflow-x:auto;max-width:100%}
.ptabs{display:flex;position:fixed;z-index:7;left:0;right:0;bottom:0;height:56px;background:var(--panel);border-top:1px solid var(--line)}
.ptabs button{flex:1;font-size:11px;color:var(--dim);display:grid;place-items:center;align-content:center;gap:3px}
.ptabs [aria-selected=true]{color:var(--text);font-weight:600}
.sec{padding:12px 16px}
.prm{grid-template-columns:84px minmax(0,1fr) 80px 28px;gap:6px 4px}
.rs{width:28px;height:36px}
.prm>label{padding-top:9px}
.prm>label:has(small){padding-top:2px}
.n,select{height:36px}
.n{font-size:16px}
select{font-size:14px}
.tri span:before{top:9px}
.lay,.lay>svg,.lay>button{height:56px}
.lay .ib{width:36px;height:44px}
input[type=range]{height:32px}
.opt{gap:8px}
.opt select{font-size:13px}
}
@media(prefers-reduced-motion:no-preference){.sw i:after{transition:.12s}
}
:host{display:block}
button:disabled{opacity:.4;cursor:default}
.canvas{position:absolute;inset:0;cursor:grab;touch-action:none;outline-offset:-3px}
.canvas canvas{width:100%;height:100%;display:block}
.qual i{background:linear-gradient(90deg,#f1f1f3 var(--q),#555 0)}
.hair{pointer-events:none;z-index:1}
.probe h3 .dim{font-weight:400}
.probe.west{right:auto;left:12px;top:54px}
.probe tr.isB td{color:#ffae57}
.probe button.dim{padding:0}
.cmp{display:flex;gap:16px;padding:8px 12px}
.cmp>span{display:grid;font-size:11px}
.cmp b{font-size:13px}
.cmp .thin{font-weight:400}
.keys button{padding:0;font-size:11px}
.notes{position:absolute;left:50%;top:52px;transform:translateX(-50%);display:grid;gap:8px;width:min(440px,calc(100% - 24px));z-index:3}
.note1{position:static;display:grid;grid-template-columns:16px 1fr 24px;gap:10px;padding:10px 8px 10px 12px;font-size:12px}
.note1 p{color:#b6b6bd;margin-top:2px;overflow-wrap:anywhere}
.note1 .ic{margin-top:1px}
.note1.warn>.ic{color:#ff8f85}
.note1 .ib{width:24px;height:24px;color:#b6b6bd}
.large{position:absolute;inset:0;background:#232325;padding:54px 20px 12px;display:flex;flex-direction:column;gap:8px;--line:#414146;--edge:#8a8a92;--text:#f1f1f3;--dim:#b6b6bd;--a:#6ea8ff;--b:#ffae57;--warn:#ff8f85;color:#f1f1f3}
.large>svg,.large>canvas,.large .pair{flex:1;min-height:0;width:100%;display:block}
.large .pair{display:grid;grid-template-columns:1fr 1.2fr;gap:24px}
.large .pair svg{width:100%;height:100%;min-width:0;min-height:0}
.large .bar{display:flex;flex-wrap:wrap;gap:8px 20px;align-items:center;justify-content:center;padding:0 150px;min-height:32px}
.large canvas.lobe{cursor:grab;touch-action:none}
.large .channel{--well:#141415;--line:#414146;width:104px}
.large~.keys,.large~.hair{display:none}
.heat{display:inline-flex;gap:6px;align-items:center;color:#b6b6bd}
.heat i{width:72px;height:8px;border-radius:4px;background:linear-gradient(90deg,rgb(64 153 255),#fff,rgb(255 64 38))}
.check{display:flex;gap:6px;align-items:center;font-size:12px;color:#d6d6da}
.thetao{display:flex;gap:8px;align-items:center;font-size:11px;color:var(--dim);white-space:nowrap}
.thetao b{font-weight:500;color:var(--text);min-width:26px}
.thetao input{width:96px}
.channel{width:96px;font-size:11px;height:24px}
.tabs .channel{margin:0 8px}
.lg i{width:22px;height:0;border-top:2px solid var(--a)}
.lg .lb{border-top:2px dashed var(--b);margin-left:8px}
svg text.strong{fill:var(--text)}
svg text.warn{fill:var(--warn)}
svg text.ofA{fill:var(--a);font-weight:600}
svg text.ofB{fill:var(--b);font-weight:600}
.maps{display:flex;gap:14px;flex:1;min-height:0;padding:0 0 16px 26px}
.map{position:relative;flex:0 1 auto;height:100%;aspect-ratio:1;max-width:50%;min-width:0}
.map canvas{width:100%;height:100%;display:block;background:repeating-linear-gradient(45deg,var(--raise) 0 4px,transparent 4px 8px);border-radius:3px}
.map .k{position:absolute;left:5px;top:5px;width:18px;height:18px;font-size:11px}
.map small{position:absolute;font-size:11px;color:var(--dim)}
.map .y{right:calc(100% + 4px);top:0}
.map .y0{right:calc(100% + 4px);top:calc(50% - 8px)}
.map .x0,.map .xm,.map .x1{top:calc(100% + 1px)}
.map .x0{left:0}
.map .xm{left:calc(50% - 8px)}
.map .x1{right:0}
.map+.map .y,.map+.map .y0{display:none}
.large .pair.maps{display:flex;justify-content:center;padding:8px 0 24px 40px}
.envs button{padding:0}
.envs button>svg{position:absolute;inset:0;width:100%;height:100%;fill:none}
.light .tone{max-width:116px}
.light .shape{max-width:96px}
.pick{width:160px}
.path b{color:var(--text)}
.about1{margin-top:4px}
.prm .hint{grid-column:2/4}
.err{color:var(--warn);font-size:11px;line-height:1.35}
.n.bad{border-color:var(--warn);color:var(--warn)}
.n.left{text-align:left}
.row{display:flex}
.offp>:not(.hint){opacity:.55}
.sv{background:linear-gradient(0deg,#000,transparent),linear-gradient(90deg,#fff,hsl(var(--h) 100% 50%));touch-action:none;cursor:crosshair}
.hue{touch-action:none;cursor:ew-resize}
.swt{border:0}
.opt>span{overflow:hidden;text-overflow:ellipsis}
.why{grid-column:1/4;background:var(--raise);border-radius:8px;padding:10px 12px;font-size:12px;color:var(--dim)}
.why b{color:var(--text)}
.why .row{margin-top:8px;flex-wrap:wrap}
.link{grid-column:2/3;text-align:left;padding:0;color:var(--dim);font-size:11px;text-decoration:underline;text-underline-offset:2px}
.lay.off>svg,.lay.off>button:first-of-type{opacity:.35}
.lay.thin,.lay.thin>svg,.lay.thin>button{height:28px}
.lay.thin small{display:none}
.sheet1{position:fixed;inset:0;z-index:20;background:#0008;display:grid;place-items:center}
.sheet1.left{place-items:start;padding:56px 12px 12px;background:transparent}
.card{background:var(--panel);border:1px solid var(--line);border-radius:12px;padding:16px;max-height:100%;overflow:auto}
.card h2{font-size:13px;font-weight:600;margin-bottom:8px}
.card td{padding:3px 16px 3px 0;font-size:12px}
.card p{margin:8px 0;max-width:46ch}
.pick1{width:min(420px,100%);max-height:min(560px,100%);display:flex;flex-direction:column;gap:8px;padding:12px;overflow:hidden}
.pick1 .list{overflow:auto;display:grid}
.pick1 .list button{text-align:left;padding:6px 8px;border-radius:6px}
.pick1 .list button:hover,.pick1 .list [aria-current=true]{background:var(--raise)}
.pick1 b{display:block;font-weight:600}
.pick1 small{font-size:11px;color:var(--dim)}
.pane.about{display:block}
.pane.about .about+.about{margin-top:16px;padding-top:12px;border-top:1px solid var(--line)}
.about .source{font-style:normal}
.pane.about .cmd{margin-top:16px}
@media(min-width:641px) and (max-width:1180px){.light{gap:8px;padding:0 10px}.envs{gap:4px}.envs button{width:36px}.envs button span{font-size:9px}.light .g{min-width:56px}.light .tone{max-width:76px}.light .shape{max-width:72px}.light select{padding:0 16px 0 6px}.light label b{margin-left:3px}}
@media(max-width:1180px){.large .bar{padding:0 8px}.pick{width:132px}.thetao input{width:64px}}
@media(max-width:640px){.large{padding:52px 8px 44px}.large .pair{grid-template-columns:1fr}.large .pair svg:nth-child(2){display:none}.large .bar{gap:4px 10px}.maps{height:180px}.pick1 .list button{min-height:44px}.notes{top:auto;bottom:48px}.cmp{display:none}.tabs .channel{display:none}}
:host(.embedded) .page{height:100%}
:host(.embedded) .app{height:100%;min-height:0}
:host(.embedded) .sheet1{position:absolute}
:host(.embedded){position:relative;overflow:hidden;border-radius:8px}
`;var pn=globalThis,jn=n=>n,Be=pn.trustedTypes,Yn=Be?Be.createPolicy("lit-html",{createHTML:n=>n}):void 0,ti="$lit$",qt=`lit$${Math.random().toFixed(9).slice(2)}$`,ei="?"+qt,$s=`<${ei}>`,te=document,ve=()=>te.createComment(""),xe=n=>n===null||typeof n!="object"&&typeof n!="function",dn=Array.isArray,ks=n=>dn(n)||typeof n?.[Symbol.iterator]=="function",an=`[ 	
\f\r]`,ge=/<(?:(!--|\/[^a-zA-Z])|(\/?[a-zA-Z][^>\s]*)|(\/?$))/g,Vn=/-->/g,Kn=/>/g,Qt=RegExp(`>|${an}(?:([^\\s"'>=/]+)(${an}*=${an}*(?:[^ 	
\f\r"'\`<>=]|("|')|))|$)`,"g"),Jn=/'/g,Qn=/"/g,ni=/^(?:script|style|textarea|title)$/i,mn=n=>(t,...e)=>({_$litType$:n,strings:t,values:e}),$=mn(1),ot=mn(2),ka=mn(3),we=Symbol.for("lit-noChange"),pt=Symbol.for("lit-nothing"),Xn=new WeakMap,Xt=te.createTreeWalker(te,129);function ii(n,t){if(!dn(n)||!n.hasOwnProperty("raw"))throw Error("invalid template strings array");return Yn!==void 0?Yn.createHTML(t):t}var Ms=(n,t)=>{let e=n.length-1,i=[],r,s=t===2?"<svg>":t===3?"<math>":"",o=ge;for(let c=0;c<e;c++){let l=n[c],h,u,d=-1,g=0;for(;g<l.length&&(o.lastIndex=g,u=o.exec(l),u!==null);)g=o.lastIndex,o===ge?u[1]==="!--"?o=Vn:u[1]!==void 0?o=Kn:u[2]!==void 0?(ni.test(u[2])&&(r=RegExp("</"+u[2],"g")),o=Qt):u[3]!==void 0&&(o=Qt):o===Qt?u[0]===">"?(o=r??ge,d=-1):u[1]===void 0?d=-2:(d=o.lastIndex-u[2].length,h=u[1],o=u[3]===void 0?Qt:u[3]==='"'?Qn:Jn):o===Qn||o===Jn?o=Qt:o===Vn||o===Kn?o=ge:(o=Qt,r=void 0);let k=o===Qt&&n[c+1].startsWith("/>")?" ":"";s+=o===ge?l+$s:d>=0?(i.push(h),l.slice(0,d)+ti+l.slice(d)+qt+k):l+qt+(d===-2?c:k)}return[ii(n,s+(n[e]||"<?>")+(t===2?"</svg>":t===3?"</math>":"")),i]},ye=class n{constructor({strings:t,_$litType$:e},i){let r;this.parts=[];let s=0,o=0,c=t.length-1,l=this.parts,[h,u]=Ms(t,e);if(this.el=n.createElement(h,i),Xt.currentNode=this.el.content,e===2||e===3){let d=this.el.content.firstChild;d.replaceWith(...d.childNodes)}for(;(r=Xt.nextNode())!==null&&l.length<c;){if(r.nodeType===1){if(r.hasAttributes())for(let d of r.getAttributeNames())if(d.endsWith(ti)){let g=u[o++],k=r.getAttribute(d).split(qt),v=/([.?@])?(.*)/.exec(g);l.push({type:1,index:s,name:v[2],strings:k,ctor:v[1]==="."?cn:v[1]==="?"?hn:v[1]==="@"?fn:ie}),r.removeAttribute(d)}else d.startsWith(qt)&&(l.push({type:6,index:s}),r.removeAttribute(d));if(ni.test(r.tagName)){let d=r.textContent.split(qt),g=d.length-1;if(g>0){r.textContent=Be?Be.emptyScript:"";for(let k=0;k<g;k++)r.append(d[k],ve()),Xt.nextNode(),l.push({type:2,index:++s});r.append(d[g],ve())}}}else if(r.nodeType===8)if(r.data===ei)l.push({type:2,index:s});else{let d=-1;for(;(d=r.data.indexOf(qt,d+1))!==-1;)l.push({type:7,index:s}),d+=qt.length-1}s++}}static createElement(t,e){let i=te.createElement("template");return i.innerHTML=t,i}};function ne(n,t,e=n,i){if(t===we)return t;let r=i!==void 0?e._$Co?.[i]:e._$Cl,s=xe(t)?void 0:t._$litDirective$;return r?.constructor!==s&&(r?._$AO?.(!1),s===void 0?r=void 0:(r=new s(n),r._$AT(n,e,i)),i!==void 0?(e._$Co??=[])[i]=r:e._$Cl=r),r!==void 0&&(t=ne(n,r._$AS(n,t.values),r,i)),t}var ln=class{constructor(t,e){this._$AV=[],this._$AN=void 0,this._$AD=t,this._$AM=e}get parentNode(){return this._$AM.parentNode}get _$AU(){return this._$AM._$AU}u(t){let{el:{content:e},parts:i}=this._$AD,r=(t?.creationScope??te).importNode(e,!0);Xt.currentNode=r;let s=Xt.nextNode(),o=0,c=0,l=i[0];for(;l!==void 0;){if(o===l.index){let h;l.type===2?h=new be(s,s.nextSibling,this,t):l.type===1?h=new l.ctor(s,l.name,l.strings,this,t):l.type===6&&(h=new un(s,this,t)),this._$AV.push(h),l=i[++c]}o!==l?.index&&(s=Xt.nextNode(),o++)}return Xt.currentNode=te,r}p(t){let e=0;for(let i of this._$AV)i!==void 0&&(i.strings!==void 0?(i._$AI(t,i,e),e+=i.strings.length-2):i._$AI(t[e])),e++}},be=class n{get _$AU(){return this._$AM?._$AU??this._$Cv}constructor(t,e,i,r){this.type=2,this._$AH=pt,this._$AN=void 0,this._$AA=t,this._$AB=e,this._$AM=i,this.options=r,this._$Cv=r?.isConnected??!0}get parentNode(){let t=this._$AA.parentNode,e=this._$AM;return e!==void 0&&t?.nodeType===11&&(t=e.parentNode),t}get startNode(){return this._$AA}get endNode(){return this._$AB}_$AI(t,e=this){t=ne(this,t,e),xe(t)?t===pt||t==null||t===""?(this._$AH!==pt&&this._$AR(),this._$AH=pt):t!==this._$AH&&t!==we&&this._(t):t._$litType$!==void 0?this.$(t):t.nodeType!==void 0?this.T(t):ks(t)?this.k(t):this._(t)}O(t){return this._$AA.parentNode.insertBefore(t,this._$AB)}T(t){this._$AH!==t&&(this._$AR(),this._$AH=this.O(t))}_(t){this._$AH!==pt&&xe(this._$AH)?this._$AA.nextSibling.data=t:this.T(te.createTextNode(t)),this._$AH=t}$(t){let{values:e,_$litType$:i}=t,r=typeof i=="number"?this._$AC(t):(i.el===void 0&&(i.el=ye.createElement(ii(i.h,i.h[0]),this.options)),i);if(this._$AH?._$AD===r)this._$AH.p(e);else{let s=new ln(r,this),o=s.u(this.options);s.p(e),this.T(o),this._$AH=s}}_$AC(t){let e=Xn.get(t.strings);return e===void 0&&Xn.set(t.strings,e=new ye(t)),e}k(t){dn(this._$AH)||(this._$AH=[],this._$AR());let e=this._$AH,i,r=0;for(let s of t)r===e.length?e.push(i=new n(this.O(ve()),this.O(ve()),this,this.options)):i=e[r],i._$AI(s),r++;r<e.length&&(this._$AR(i&&i._$AB.nextSibling,r),e.length=r)}_$AR(t=this._$AA.nextSibling,e){for(this._$AP?.(!1,!0,e);t!==this._$AB;){let i=jn(t).nextSibling;jn(t).remove(),t=i}}setConnected(t){this._$AM===void 0&&(this._$Cv=t,this._$AP?.(t))}},ie=class{get tagName(){return this.element.tagName}get _$AU(){return this._$AM._$AU}constructor(t,e,i,r,s){this.type=1,this._$AH=pt,this._$AN=void 0,this.element=t,this.name=e,this._$AM=r,this.options=s,i.length>2||i[0]!==""||i[1]!==""?(this._$AH=Array(i.length-1).fill(new String),this.strings=i):this._$AH=pt}_$AI(t,e=this,i,r){let s=this.strings,o=!1;if(s===void 0)t=ne(this,t,e,0),o=!xe(t)||t!==this._$AH&&t!==we,o&&(this._$AH=t);else{let c=t,l,h;for(t=s[0],l=0;l<s.length-1;l++)h=ne(this,c[i+l],e,l),h===we&&(h=this._$AH[l]),o||=!xe(h)||h!==this._$AH[l],h===pt?t=pt:t!==pt&&(t+=(h??"")+s[l+1]),this._$AH[l]=h}o&&!r&&this.j(t)}j(t){t===pt?this.element.removeAttribute(this.name):this.element.setAttribute(this.name,t??"")}},cn=class extends ie{constructor(){super(...arguments),this.type=3}j(t){this.element[this.name]=t===pt?void 0:t}},hn=class extends ie{constructor(){super(...arguments),this.type=4}j(t){this.element.toggleAttribute(this.name,!!t&&t!==pt)}},fn=class extends ie{constructor(t,e,i,r,s){super(t,e,i,r,s),this.type=5}_$AI(t,e=this){if((t=ne(this,t,e,0)??pt)===we)return;let i=this._$AH,r=t===pt&&i!==pt||t.capture!==i.capture||t.once!==i.once||t.passive!==i.passive,s=t!==pt&&(i===pt||r);r&&this.element.removeEventListener(this.name,this,i),s&&this.element.addEventListener(this.name,this,t),this._$AH=t}handleEvent(t){typeof this._$AH=="function"?this._$AH.call(this.options?.host??this.element,t):this._$AH.handleEvent(t)}},un=class{constructor(t,e,i){this.element=t,this.type=6,this._$AN=void 0,this._$AM=e,this.options=i}get _$AU(){return this._$AM._$AU}_$AI(t){ne(this,t)}};var As=pn.litHtmlPolyfillSupport;As?.(ye,be),(pn.litHtmlVersions??=[]).push("3.3.3");var ri=(n,t,e)=>{let i=e?.renderBefore??t,r=i._$litPart$;if(r===void 0){let s=e?.renderBefore??null;i._$litPart$=r=new be(t.insertBefore(ve(),s),s,void 0,e??{})}return r._$AI(n),r};var Re=(n,t)=>.2126*n[4*t]+.7152*n[4*t+1]+.0722*n[4*t+2];function si(n,t,e){let i=t*e,r=new Float64Array(i),s=0;for(let g=0;g<e;g++){let k=Math.sin((g+.5)/e*Math.PI);for(let v=0;v<t;v++){let p=0;for(let w=-1;w<=1;w++)for(let b=-1;b<=1;b++)p=Math.max(p,Re(n,Math.min(e-1,Math.max(0,g+w))*t+(v+b+t)%t));s+=r[g*t+v]=(.5*p+.5*Re(n,g*t+v))*k}}let o=new Float32Array(4*i);if(!(s>0))return o;let c=r.map(g=>g*i/s),l=[],h=[],u=new Float64Array(i).fill(1),d=new Uint32Array(i);for(let g=0;g<i;g++)(c[g]<1?l:h).push(g);for(;l.length&&h.length;){let g=l.pop(),k=h[h.length-1];u[g]=c[g],d[g]=k,c[k]+=c[g]-1,c[k]<1&&l.push(h.pop())}for(let g=0;g<i;g++){let k=Math.sin((Math.floor(g/t)+.5)/e*Math.PI);o.set([u[g],d[g],r[g]/s*i/(2*Math.PI*Math.PI*k),0],4*g)}return o}function oi(n,t,e){let i=0;for(let o=0;o<t*e;o++)Re(n,o)>Re(n,i)&&(i=o);let r=(Math.floor(i/t)+.5)/e*Math.PI,s=(i%t+.5)/t*2*Math.PI;return[-Math.sin(r)*Math.sin(s),Math.cos(r),Math.sin(r)*Math.cos(s)]}function ai({pixels:n,width:t,height:e},i,{band:r,reach:s,albedo:o}){let c=[0,0,0],l=[0,0,0];for(let v=0;v<e;v++){let p=(v+.5)/e*Math.PI,w=Math.cos(p)*Math.sin(p)*(Math.PI/e)*(2*Math.PI/t);if(w>0)for(let b=0;b<t;b++)for(let A=0;A<3;A++)c[A]+=n[4*(v*t+b)+A]*w}let[h,u]=r.map(v=>Math.floor(e*(90+v)/180)),d=t/2+i/360*t,g=t*s/360,k=0;for(let v=h;v<Math.max(u,h+1);v++)for(let p=Math.floor(d-g);p<=Math.floor(d+g);p++,k++)for(let w=0;w<3;w++)l[w]+=n[4*(v*t+(p%t+t)%t)+w];return l.map((v,p)=>Math.min(o[1],Math.max(o[0],Math.PI*v/k/Math.max(c[p],1e-12))))}function hi(n){let t=n.reduce((v,p)=>v+p.faces.length/3,0),e=new Float32Array(3*t),i=new Float32Array(3*t),r=new Float32Array(3*t),s=new Float32Array(12*Math.max(t,1)),o=new Float32Array(20*Math.max(t,1)),c=new Uint32Array(t),l=[],h=0;for(let v of n)for(let p=0;p<v.faces.length;p+=3,h++){c[h]=h,l.push([v,p]);for(let w=0;w<3;w++){let[b,A,T]=[0,1,2].map(B=>v.positions[3*v.faces[p+B]+w]);e[3*h+w]=Math.min(b,A,T),i[3*h+w]=Math.max(b,A,T),r[3*h+w]=(e[3*h+w]+i[3*h+w])/2}}let u=[],d=(v,p)=>{let w=[1/0,1/0,1/0,-1/0,-1/0,-1/0];for(let b=v;b<p;b++)fi(w,e,i,c[b]);return w},g=(v,p,w,b)=>{let A=d(p,w);if(u[v]=[A,p,w-p],w-p<=4||b>=36)return;let T=_s(e,i,r,c,p,w),B=p;if(T){for(let I=p;I<w;I++)if(r[3*c[I]+T.axis]<T.at){let G=c[I];c[I]=c[B],c[B++]=G}}if(B===p||B===w){if(w-p<=16)return;B=p+w>>1}let W=u.length;u.push(null,null),u[v]=[A,W,0],g(W,p,B,b+1),g(W+1,B,w,b+1)};t&&(u.push(null),g(0,0,t,0));let k=new Float32Array(8*Math.max(u.length,1));u.forEach(([v,p,w],b)=>k.set([v[0],v[1],v[2],p,v[3],v[4],v[5],w],8*b));for(let v=0;v<t;v++)Ss(s,o,v,...l[c[v]]);return{nodes:k,places:s,looks:o,count:u.length,triangles:t}}function fi(n,t,e,i){for(let r=0;r<3;r++)n[r]=Math.min(n[r],t[3*i+r]),n[3+r]=Math.max(n[3+r],e[3*i+r])}var li=n=>{let[t,e,i]=[n[3]-n[0],n[4]-n[1],n[5]-n[2]];return t<0?0:t*e+e*i+i*t},gn=()=>[1/0,1/0,1/0,-1/0,-1/0,-1/0];function _s(n,t,e,i,r,s){let o=null,c=1/0;for(let l=0;l<3;l++){let h=1/0,u=-1/0;for(let p=r;p<s;p++){let w=e[3*i[p]+l];h=Math.min(h,w),u=Math.max(u,w)}if(!(u>h))continue;let d=Array.from({length:16},()=>({box:gn(),count:0}));for(let p=r;p<s;p++){let w=d[Math.min(15,Math.floor((e[3*i[p]+l]-h)/(u-h)*16))];fi(w.box,n,t,i[p]),w.count++}let g=[],k=gn(),v=0;for(let p=15;p>0;p--)ci(k,d[p].box),v+=d[p].count,g[p]=li(k)*v;k=gn(),v=0;for(let p=1;p<16;p++){ci(k,d[p-1].box),v+=d[p-1].count;let w=li(k)*v+g[p];w<c&&(c=w,o={axis:l,at:h+(u-h)*p/16})}}return o}function ci(n,t){for(let e=0;e<3;e++)n[e]=Math.min(n[e],t[e]),n[3+e]=Math.max(n[3+e],t[3+e])}function Ss(n,t,e,i,r){let s=[0,1,2].map(u=>i.faces[r+u]),o=u=>[0,1,2].map(d=>i.positions[3*s[u]+d]),[c,l,h]=[o(0),o(1),o(2)];n.set([...c,i.kind,l[0]-c[0],l[1]-c[1],l[2]-c[2],0,h[0]-c[0],h[1]-c[1],h[2]-c[2],0],12*e);for(let u=0;u<3;u++){let d=i.growth?i.growth[s[u]]:.5;t.set([i.normals[3*s[u]],i.normals[3*s[u]+1],i.normals[3*s[u]+2],d],20*e+4*u),i.uvs&&t.set([i.uvs[2*s[u]],i.uvs[2*s[u]+1]],20*e+12+2*u)}}function ui({nodes:n,places:t,count:e},i,r){if(!e)return null;let s=null,o=1/0,c=r.map(h=>1/(Math.abs(h)<1e-12?1e-12:h)),l=[0];for(;l.length;){let h=8*l.pop(),u=0,d=o;for(let v=0;v<3;v++){let p=(n[h+v]-i[v])*c[v],w=(n[h+4+v]-i[v])*c[v];u=Math.max(u,Math.min(p,w)),d=Math.min(d,Math.max(p,w))}if(u>d*(1+1e-6))continue;let g=n[h+3],k=n[h+7];if(!k){l.push(g,g+1);continue}for(let v=g;v<g+k;v++){let p=12*v,[w,b]=[[t[p+4],t[p+5],t[p+6]],[t[p+8],t[p+9],t[p+10]]],A=Zt(r,b),T=$t(w,A);if(Math.abs(T)<1e-14)continue;let B=[i[0]-t[p],i[1]-t[p+1],i[2]-t[p+2]],W=$t(B,A)/T,I=Zt(B,w),G=$t(r,I)/T,Y=$t(b,I)/T;W>=0&&G>=0&&W+G<=1&&Y>1e-4&&Y<o&&(o=Y,s={t:Y,i:v,u:W,v:G})}}return s}var $t=(n,t)=>n[0]*t[0]+n[1]*t[1]+n[2]*t[2],Zt=(n,t)=>[n[1]*t[2]-n[2]*t[1],n[2]*t[0]-n[0]*t[2],n[0]*t[1]-n[1]*t[0]],mt=(n,t)=>n.map(e=>e*t),Pt=(n,t)=>n.map((e,i)=>e+t[i]),Ft=n=>mt(n,1/Math.hypot(...n));var zs=20;function pi({azimuth:n,elevation:t,distance:e,target:i},r,s){let o=n*Math.PI/180,c=t*Math.PI/180,l=[Math.cos(c)*Math.sin(o),Math.sin(c),Math.cos(c)*Math.cos(o)],h=Pt(i,mt(l,e)),u=mt(l,-1),d=Ft(Zt(u,[0,1,0])),g=Zt(d,u),k=Math.tan(zs*Math.PI/360)/Math.min(1,r/s);return{origin:h,forward:u,right:d,up:g,half:k,aspect:r/s}}function di({origin:n,forward:t,right:e,up:i,half:r,aspect:s},o,c){let l=mt(e,(2*o-1)*s*r),h=mt(i,(1-2*c)*r);return{o:n,d:Ft(Pt(t,Pt(l,h)))}}var Us={both:0,model:1,light:2},Ts=8;function mi({width:n,height:t,sample:e,seed:i=1,view:r,light:s,furnace:o,scene:c,estimator:l="both",depth:h}){let u=new Float32Array(176),d=(I,...G)=>u.set(G,4*I),{origin:g,forward:k,right:v,up:p,half:w,aspect:b}=r;d(0,n,t,e,i),d(1,...g,w),d(2,...v,b),d(3,...p,o?1:0),d(4,...k,h??(o?256:12));let A=o?[]:s.lamps.slice(0,Ts),T=!o&&s.picture;d(5,...o?[1,1,1]:T?[1,1,1].map(I=>I*(s.scale??1)):s.surround,T?1:0);let B=(s.turn??0)*Math.PI/180;d(6,Math.cos(B),Math.sin(B),A.length,T?A.length?.5:1:0),d(7,0,c.count,...o?[0,0]:s.fade),d(11,...s.groundColour??[0,0,0],0),d(8,...c.core?.centre??[0,0,0],c.core?.radius??0),d(9,0,0,Us[l],0),T&&d(10,T.width,T.height,0,0);let W=A.reduce((I,G)=>I+G.share,0);return A.forEach((I,G)=>{d(12+4*G,...I.centre,I.shape==="disk"?1:0),d(13+4*G,...I.a,I.area),d(14+4*G,...I.b,I.share/W),d(15+4*G,...I.radiance,0)}),u}var Es={A:0,B:1,wipe:2,side:3,diff:4},Is={none:0,reinhard:1,filmic:2};function gi({canvas:n,mode:t,wipe:e,exposure:i,tone:r,a:s,b:o}){let c=new Float32Array(16);return c.set([Es[t],e,s.width,s.height],0),c.set([2**i,Is[r],o.width,o.height],4),c.set([1/s.samples,1/o.samples,0,0],8),c.set([n.width,n.height,0,0],12),c}function Bt(n,t){let e=Uint8Array.from(atob(n),i=>i.charCodeAt(0));return new t(e.buffer)}function qe(n){return Float32Array.from(n,t=>{let e=t&32768?-1:1,i=t>>10&31,r=t&1023;return i===0?e*r*2**-24:i===31?r?NaN:e*(1/0):e*(1+r/1024)*2**(i-15)})}var De=class{live=!0;constructor(t){this.token=t}async#t(t,e){let i;try{i=await fetch(t,{method:"POST",body:JSON.stringify(e),headers:{"Content-Type":"application/json","X-Gonio-Token":this.token}})}catch{throw new Error("gonio view is not running any more; start it again and reload this page.")}let r=await i.json().catch(()=>({error:`The server answered ${i.status}.`}));if(!i.ok)throw Object.assign(new Error(r.error),r);return r}start(){return this.#t("/api/start",{})}model(t){return this.#t("/api/model",{text:t})}options(t){return this.#t("/api/options",{text:t})}code(t,e){return this.#t("/api/code",{text:t,language:e}).then(i=>i.text)}async watch(t){for(;;){try{let e=await fetch("/api/changes",{method:"POST",body:"{}",headers:{"Content-Type":"application/json","X-Gonio-Token":this.token}});if(!e.ok)return;let i=e.body.pipeThrough(new TextDecoderStream).getReader();for(let r="";;){let{value:s,done:o}=await i.read();if(o)break;let c=(r+s).split(`

`);r=c.pop();for(let l of c)l.startsWith("data: ")&&t(JSON.parse(l.slice(6)))}}catch{}await new Promise(e=>setTimeout(e,2e3))}}},He=class{live=!1;constructor(t){this.data=t}async start(){return this.data}async model(t){let[e,i=""]=[t.split(":")[0],t.slice(t.indexOf(":")+1)],r=this.data.models[t]??Object.values(this.data.models).find(h=>h.name===e);if(!r)throw new Error(`This saved page holds ${this.data.show.join(" and ")} alone; 'gonio view' has all models.`);let s=new Map(t.includes(":")?i.split(",").map(h=>[h.slice(0,h.indexOf("=")),h.slice(h.indexOf("=")+1)]):[]);for(let{path:h,value:u,default:d}of r.models)if((s.get(h)??r.start[h]??d)!==u)throw new Error("This saved page has its layers as they are; 'gonio view' changes them.");let o=r.options.map(h=>[h.path,s.get(h.path)??r.start[h.path]??h.default]),c=o.every(([h,u],d)=>r.options[d].value===u)?r:this.#t(r,`${e}|${o.map(([h,u])=>`${h}=${u}`).join()}`),l=c.parameters.map(h=>{let u=s.has(h.path)?s.get(h.path).split("/").map(Number):[r.start[h.path]??h.default].flat();return{...h,value:Array.from({length:h.width},(d,g)=>u[g]??u[0])}});return{...c,parameters:l}}#t(t,e){let i=this.data.variants?.[e];if(!i)throw new Error("This saved page has no shader for that choice; 'gonio view' has them all.");let r=s=>i[s].map(o=>this.data.pool[s][o]).join(`

`);return{...t,...i.about,code:{wgsl:r("wgsl"),essl:r("essl")}}}async options(t){return(await this.model(t)).options}async code(t,e){let i=(await this.model(t)).code[e];if(i===void 0)throw new Error("This saved page holds WGSL and GLSL ES only; 'gonio view' has every language.");return i}watch(){}},Ge=class{live=!0;#t=new Map;#s=0;constructor(t){this.widget=t,t.on("msg:custom",e=>{let i=this.#t.get(e.id);i&&(this.#t.delete(e.id),e.error?i.reject(new Error(e.error)):i.resolve(e.answer))})}#e(t,e){let i=++this.#s;return this.widget.send({id:i,question:t,body:e}),new Promise((r,s)=>{this.#t.set(i,{resolve:r,reject:s}),setTimeout(()=>{this.#t.delete(i)&&s(new Error("The notebook's kernel does not answer; is it busy?"))},3e4)})}start(){return this.#e("start",{})}model(t){return this.#e("model",{text:t})}options(t){return this.#e("options",{text:t})}code(t,e){return this.#e("code",{text:t,language:e}).then(i=>i.text)}watch(){}};var vi=`@group(0) @binding(0) var<uniform> U: array<vec4f, 44>;
@group(0) @binding(1) var<uniform> P: array<vec4f, MEMBERS>;
@group(0) @binding(2) var<storage, read> nodes: array<vec4f>;
@group(0) @binding(3) var<storage, read> places: array<vec4f>;
@group(0) @binding(4) var<storage, read> looks: array<vec4f>;
@group(0) @binding(5) var<storage, read> alias_table: array<vec4f>;
@group(0) @binding(6) var sky: texture_2d<f32>;
@group(0) @binding(7) var maps: texture_2d_array<f32>;
@group(0) @binding(8) var<storage, read> before: array<vec4f>;
@group(0) @binding(9) var<storage, read_write> film: array<vec4f>;

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
fn lamp_pdf(k: i32, t: f32, d: vec3f) -> f32 {
let n: vec3f = turned(normalize(cross(U[13 + 4 * k].xyz, U[14 + 4 * k].xyz)), 1.0);
return (1.0 - U[6].w) * U[14 + 4 * k].w * t * t / (max(-dot(n, d), 1e-6) * U[13 + 4 * k].w);
}
struct Light { d: vec3f, far: f32, radiance: vec3f, pdf: f32 }
fn sample_light(o: vec3f, u: vec2f, choice: vec2f) -> Light {
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
var rest: f32 = (choice.x - U[6].w) / (1.0 - U[6].w);
for (; k < lamp_count() - 1; k++) {
if (rest < U[14 + 4 * k].w) { break; }
rest -= U[14 + 4 * k].w;
}
var s: vec2f = 2.0 * u - 1.0;
if (U[12 + 4 * k].w > 0.5) { s = sqrt(u.x) * vec2f(cos(TAU * u.y), sin(TAU * u.y)); }
let at: vec3f = turned(U[12 + 4 * k].xyz + s.x * U[13 + 4 * k].xyz + s.y * U[14 + 4 * k].xyz, 1.0);
let way: vec3f = at - o;
let t: f32 = length(way);
let d: vec3f = way / t;
let n: vec3f = turned(normalize(cross(U[13 + 4 * k].xyz, U[14 + 4 * k].xyz)), 1.0);
if (dot(n, d) >= 0.0 || lamp_count() < 1) { return Light(d, 0.0, vec3f(0.0), 0.0); }
return Light(d, t * 0.9999, U[15 + 4 * k].xyz, lamp_pdf(k, t, d));
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
if (pdf >= 0.0) { w = pdf / (pdf + lamp_pdf(k, hit.t, d)); if (way == 1) { w = 1.0; } if (way == 2) { w = 0.0; } }
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
let light: Light = sample_light(p, u_light, u_choice);
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

@compute @workgroup_size(8, 8) fn main(@builtin(global_invocation_id) id: vec3u) {
let size = vec2u(U[0].xy);
let at = vec2u(id.x, id.y + u32(U[9].x));
if (at.x >= size.x || at.y >= min(size.y, u32(U[9].y))) { return; }
let i = at.y * size.x + at.x;
film[i] = select(before[i], vec4f(0.0), U[0].z < 0.5) + pixel(at);
}
`,xi=`
const float TAU = 6.2831853;
const float FAR = 1e30;
vec4 map_texel(ivec2 at, int layer) {
ivec2 size = ivec2(textureSize(maps, 0).xy);
return texelFetch(maps, ivec3(((at % size) + size) % size, layer), 0);
}
vec4 map_nearest(vec2 uv, int layer) {
return map_texel(ivec2(floor(uv * vec2(textureSize(maps, 0).xy))), layer);
}
vec4 map_linear(vec2 uv, int layer) {
vec2 at = uv * vec2(textureSize(maps, 0).xy) - 0.5;
vec2 low = floor(at);
ivec2 k = ivec2(low);
vec2 f = at - low;
return mix(mix(map_texel(k, layer), map_texel(k + ivec2(1, 0), layer), f.x),
mix(map_texel(k + ivec2(0, 1), layer), map_texel(k + ivec2(1, 1), layer), f.x), f.y);
}
//MODEL

uint hash(uint x0) {
uint x = x0;
x ^= x >> 16u; x *= 0x7feb352du; x ^= x >> 15u; x *= 0x846ca68bu; x ^= x >> 16u;
return x;
}
uint owen(uint x0, uint seed) {
uint x = reverse_bits(x0);
x ^= x * 0x3d20adeau; x += seed; x *= (seed >> 16u) | 1u; x ^= x * 0x05526c56u; x ^= x * 0x53a22864u;
return reverse_bits(x);
}
uvec2 sobol2(uint index) {
uint second = 0u;
uint column = 0x80000000u;
for (uint i = index; i != 0u; i >>= 1u) {
if ((i & 1u) != 0u) { second ^= column; }
column ^= column >> 1u;
}
return uvec2(reverse_bits(index), second);
}
uint pixel_seed;
vec2 unit2(uint pair) {
uint seed = hash(pixel_seed ^ (pair * 0x9e3779b9u));
uvec2 point = sobol2(owen(uint(U[0].z), seed));
uint x = owen(point.x, hash(seed ^ 0x68bc21ebu));
uint y = owen(point.y, hash(seed ^ 0x02e5be93u));
return vec2(float(x >> 8u), float(y >> 8u)) * (1.0 / 16777216.0);
}
struct Hit { float t; int what; float u; float v; };
float away_from_zero(float x) { return ((abs(x) < 1e-12) ? (1e-12) : (x)); }
float box(vec3 o, vec3 inv, vec3 low, vec3 high, float far) {
vec3 a = (low - o) * inv;
vec3 b = (high - o) * inv;
vec3 near = min(a, b);
vec3 away = max(a, b);
float t0 = max(max(near.x, near.y), max(near.z, 0.0));
float t1 = min(min(away.x, away.y), min(away.z, far));
return ((t0 <= t1 * 1.0000004) ? (t0) : (FAR));
}
float ball(vec3 o, vec3 d, float far) {
vec3 c = U[8].xyz - o;
float b = dot(c, d);
vec3 e = c - b * d;
float q = U[8].w * U[8].w - dot(e, e);
if (q <= 0.0 || U[8].w <= 0.0) { return FAR; }
float s = sqrt(q);
float t = ((b - s < 1e-4) ? (b + s) : (b - s));
return ((t > 1e-4 && t < far) ? (t) : (FAR));
}
int lamp_count() { return int(U[6].z); }
vec3 turned(vec3 v, float sense) {
float s = U[6].y * sense;
return vec3(U[6].x * v.x + s * v.z, v.y, U[6].x * v.z - s * v.x);
}
Hit meet(vec3 o, vec3 d, float far, bool any) {
Hit hit = Hit(far, -1, 0.0, 0.0);
float t_ball = ball(o, d, hit.t);
if (t_ball < hit.t) { hit = Hit(t_ball, -2, 0.0, 0.0); if (any) { return hit; } }
for (int k = 0; k < lamp_count(); k++) {
vec3 c = turned(U[12 + 4 * k].xyz, 1.0);
vec3 a = turned(U[13 + 4 * k].xyz, 1.0);
vec3 b = turned(U[14 + 4 * k].xyz, 1.0);
vec3 n = cross(a, b);
float down = dot(n, d);
float t = dot(n, c - o) / ((down == 0.0) ? (1e-20) : (down));
if (t > 1e-3 && t < hit.t) {
vec3 q = o + t * d - c;
float x = dot(q, a) / dot(a, a);
float y = dot(q, b) / dot(b, b);
float inside = ((U[12 + 4 * k].w > 0.5) ? (sqrt(x * x + y * y)) : (max(abs(x), abs(y))));
if (inside <= 1.0) { hit = Hit(t, -3 - k, 0.0, 0.0); if (any) { return hit; } }
}
}
if (U[7].y < 1.0) { return hit; }
vec3 inv = 1.0 / vec3(away_from_zero(d.x), away_from_zero(d.y), away_from_zero(d.z));
int stack[40];
int top = 0;
int at = 0;
if (box(o, inv, row_of(nodes, int(0)).xyz, row_of(nodes, int(1)).xyz, hit.t) >= FAR) { return hit; }
for (;;) {
int first = int(row_of(nodes, int(2 * at)).w);
int count = int(row_of(nodes, int(2 * at + 1)).w);
if (count > 0) {
for (int i = first; i < first + count; i++) {
vec3 e1 = row_of(places, int(3 * i + 1)).xyz;
vec3 e2 = row_of(places, int(3 * i + 2)).xyz;
vec3 h = cross(d, e2);
float a = dot(e1, h);
if (abs(a) > 1e-14) {
float f = 1.0 / a;
vec3 s = o - row_of(places, int(3 * i)).xyz;
float u = f * dot(s, h);
vec3 q = cross(s, e1);
float v = f * dot(d, q);
float t = f * dot(e2, q);
if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-4 && t < hit.t) {
hit = Hit(t, i, u, v);
if (any) { return hit; }
}
}
}
if (top == 0) { break; }
top--; at = stack[top];
} else {
int one = first;
int two = first + 1;
float t1 = box(o, inv, row_of(nodes, int(2 * one)).xyz, row_of(nodes, int(2 * one + 1)).xyz, hit.t);
float t2 = box(o, inv, row_of(nodes, int(2 * two)).xyz, row_of(nodes, int(2 * two + 1)).xyz, hit.t);
if (t2 < t1) { int k = one; one = two; two = k; float t = t1; t1 = t2; t2 = t; }
if (t1 >= FAR) { if (top == 0) { break; } top--; at = stack[top]; }
else { at = one; if (t2 < FAR) { stack[top] = two; top++; } }
}
}
return hit;
}
float ground_at(vec3 o, vec3 d) {
float t = -o.y / ((d.y == 0.0) ? (1e-20) : (d.y));
return ((U[7].w > 0.0 && t > 1e-4) ? (t) : (FAR));
}
float ground_share(vec3 p) {
float t = clamp((length(p.xz) - U[7].z) / max(U[7].w - U[7].z, 1e-6), 0.0, 1.0);
float x = 1.0 - t * t * (3.0 - 2.0 * t);
return x * x;
}
vec3 sky_texel(int x, int y) {
int w = int(U[10].x);
return texelFetch(sky, ivec2(((x % w) + w) % w, clamp(y, 0, int(U[10].y) - 1)), 0).rgb;
}
vec2 sky_place(vec3 d) {
vec3 w = turned(d, -1.0);
return vec2(fract(atan(-w.x, w.z) / TAU), acos(clamp(w.y, -1.0, 1.0)) / (0.5 * TAU)) * U[10].xy;
}
vec3 surround(vec3 d) {
if (U[5].w < 0.5) { return U[5].xyz; }
vec2 at = sky_place(d) - 0.5;
vec2 low = floor(at);
vec2 f = at - low;
ivec2 k = ivec2(low);
vec3 value = mix(mix(sky_texel(k.x, k.y), sky_texel(k.x + 1, k.y), f.x),
mix(sky_texel(k.x, k.y + 1), sky_texel(k.x + 1, k.y + 1), f.x), f.y);
return value * U[5].xyz;
}
float sky_pdf(vec3 d) {
uvec2 at = min(uvec2(sky_place(d)), uvec2(U[10].xy) - 1u);
return U[6].w * row_of(alias_table, int(at.y * uint(U[10].x) + at.x)).z;
}
float lamp_pdf(int k, float t, vec3 d) {
vec3 n = turned(normalize(cross(U[13 + 4 * k].xyz, U[14 + 4 * k].xyz)), 1.0);
return (1.0 - U[6].w) * U[14 + 4 * k].w * t * t / (max(-dot(n, d), 1e-6) * U[13 + 4 * k].w);
}
struct Light { vec3 d; float far; vec3 radiance; float pdf; };
Light sample_light(vec3 o, vec2 u, vec2 choice) {
if (choice.x < U[6].w) {
uvec2 size = uvec2(U[10].xy);
float x = choice.x / U[6].w * float(size.x * size.y);
uint cell = min(uint(x), size.x * size.y - 1u);
vec4 entry = row_of(alias_table, int(cell));
uint k = ((choice.y < entry.x) ? (cell) : (uint(entry.y)));
vec2 place = vec2(float(k % size.x) + u.x, float(k / size.x) + u.y) / U[10].xy;
float th = place.y * 0.5 * TAU;
float ph = place.x * TAU;
vec3 d = turned(vec3(-sin(th) * sin(ph), cos(th), sin(th) * cos(ph)), 1.0);
return Light(d, FAR, surround(d), U[6].w * row_of(alias_table, int(k)).z);
}
int k = 0;
float rest = (choice.x - U[6].w) / (1.0 - U[6].w);
for (; k < lamp_count() - 1; k++) {
if (rest < U[14 + 4 * k].w) { break; }
rest -= U[14 + 4 * k].w;
}
vec2 s = 2.0 * u - 1.0;
if (U[12 + 4 * k].w > 0.5) { s = sqrt(u.x) * vec2(cos(TAU * u.y), sin(TAU * u.y)); }
vec3 at = turned(U[12 + 4 * k].xyz + s.x * U[13 + 4 * k].xyz + s.y * U[14 + 4 * k].xyz, 1.0);
vec3 way = at - o;
float t = length(way);
vec3 d = way / t;
vec3 n = turned(normalize(cross(U[13 + 4 * k].xyz, U[14 + 4 * k].xyz)), 1.0);
if (dot(n, d) >= 0.0 || lamp_count() < 1) { return Light(d, 0.0, vec3(0.0), 0.0); }
return Light(d, t * 0.9999, U[15 + 4 * k].xyz, lamp_pdf(k, t, d));
}
vec3 any_frame(vec3 n) {
return normalize(cross(((abs(n.y) > 0.99) ? (vec3(1.0, 0.0, 0.0)) : (vec3(0.0, 1.0, 0.0))), n));
}
vec3 path(vec3 origin, vec3 direction) {
vec3 o = origin;
vec3 d = direction;
vec3 L = vec3(0.0);
vec3 T = vec3(1.0);
float pdf = -1.0;
bool furnace = U[3].w > 0.5;
int way = int(U[9].z);
int depth = int(U[4].w);
for (int b = 0; b < depth; b++) {
Hit hit = meet(o, d, FAR, false);
float t_ground = ground_at(o, d);
if (t_ground < hit.t && unit2(uint(4 * b + 4)).y < ground_share(o + t_ground * d)) {
hit = Hit(t_ground, 1 << 30, 0.0, 0.0);
}
if (hit.what == -1) {
float w = 1.0;
if (U[6].w > 0.0 && pdf >= 0.0) { w = pdf / (pdf + sky_pdf(d)); if (way == 1) { w = 1.0; } if (way == 2) { w = 0.0; } }
L += T * surround(d) * w;
break;
}
if (hit.what < -2) {
int k = -3 - hit.what;
vec3 n = turned(cross(U[13 + 4 * k].xyz, U[14 + 4 * k].xyz), 1.0);
if (dot(n, d) < 0.0) {
float w = 1.0;
if (pdf >= 0.0) { w = pdf / (pdf + lamp_pdf(k, hit.t, d)); if (way == 1) { w = 1.0; } if (way == 2) { w = 0.0; } }
L += T * U[15 + 4 * k].xyz * w;
}
break;
}
if (b == depth - 1) { break; }
vec3 x = o + hit.t * d;
vec3 p = x;
vec3 ng;
vec3 n;
vec3 du;
vec2 uv = vec2(0.0);
float growth = 0.5;
int kind = 0;
if (hit.what == 1 << 30) {
ng = vec3(0.0, 1.0, 0.0);
n = ng;
du = vec3(1.0, 0.0, 0.0);
kind = 3;
} else if (hit.what == -2) {
n = normalize(x - U[8].xyz);
ng = n;
du = vec3(-n.z, 0.0, n.x);
uv = vec2(fract(atan(-n.x, -n.z) / TAU + 1.0), acos(clamp(n.y, -1.0, 1.0)) / (0.5 * TAU));
p = U[8].xyz + U[8].w * n;
} else {
int i = hit.what;
vec3 p0 = row_of(places, int(3 * i)).xyz;
vec3 e1 = row_of(places, int(3 * i + 1)).xyz;
vec3 e2 = row_of(places, int(3 * i + 2)).xyz;
vec3 n0 = row_of(looks, int(5 * i)).xyz;
vec3 n1 = row_of(looks, int(5 * i + 1)).xyz;
vec3 n2 = row_of(looks, int(5 * i + 2)).xyz;
float a = 1.0 - hit.u - hit.v;
kind = int(row_of(places, int(3 * i)).w);
ng = normalize(cross(e1, e2));
n = normalize(a * n0 + hit.u * n1 + hit.v * n2);
growth = a * row_of(looks, int(5 * i)).w + hit.u * row_of(looks, int(5 * i + 1)).w + hit.v * row_of(looks, int(5 * i + 2)).w;
vec4 t01 = row_of(looks, int(5 * i + 3));
vec2 t2 = row_of(looks, int(5 * i + 4)).xy;
uv = a * t01.xy + hit.u * t01.zw + hit.v * t2;
vec2 s1 = t01.zw - t01.xy;
vec2 s2 = t2 - t01.xy;
du = (e1 * s2.y - e2 * s1.y) * sign(s1.x * s2.y - s1.y * s2.x);
p = p0 + hit.u * e1 + hit.v * e2;
float side = ((dot(ng, d) < 0.0) ? (1.0) : (-1.0));
vec3 q0 = p - p0;
vec3 q1 = q0 - e1;
vec3 q2 = q0 - e2;
float l0 = min(0.0, side * dot(q0, n0));
float l1 = min(0.0, side * dot(q1, n1));
float l2 = min(0.0, side * dot(q2, n2));
if (kind == 0) { p -= side * (a * l0 * n0 + hit.u * l1 * n1 + hit.v * l2 * n2); }
}
if (kind == 0) {
vec3 bump = normal_at(uv);
if (abs(bump.x) + abs(bump.y) > 1e-4) {
vec3 across = du - dot(du, n) * n;
vec3 u_axis = ((dot(across, across) > 1e-16) ? (across / max(length(across), 1e-20)) : (any_frame(n)));
n = normalize(bump.x * u_axis + bump.y * cross(n, u_axis) + bump.z * n);
}
}
if (dot(ng, d) > 0.0) { ng = -ng; n = -n; }
float below = dot(n, d);
if (below > -1e-3) { n = normalize(n - (below + 1e-3) * d); }
du = du - dot(du, n) * n;
vec3 tx = ((dot(du, du) > 1e-16) ? (du / max(length(du), 1e-20)) : (any_frame(n)));
vec3 ty = cross(n, tx);
vec3 wo = vec3(-dot(d, tx), -dot(d, ty), -dot(d, n));
p += 1e-4 * ng;
vec2 u_light = unit2(uint(4 * b + 1));
vec2 u_choice = unit2(uint(4 * b + 2));
vec2 u_model = unit2(uint(4 * b + 3));
bool test = kind == 0;
vec3 grey = ((kind == 3) ? (U[11].xyz) : (vec3(((kind == 1) ? (0.32) : (0.12))))) / (0.5 * TAU);
Model m = model_at(uv, growth, hit.t);
bool lit = !furnace && way != 1 && (U[6].w > 0.0 || lamp_count() > 0);
if (lit) {
Light light = sample_light(p, u_light, u_choice);
vec3 wi = vec3(dot(light.d, tx), dot(light.d, ty), dot(light.d, n));
if (light.pdf > 0.0 && wi.z > 0.0) {
vec3 f = grey;
float q = wi.z / (0.5 * TAU);
if (test) { f = model_eval(m, wi, wo); q = model_pdf(m, wi, wo); }
if (way == 2) { q = 0.0; }
vec3 e = f * light.radiance * (wi.z / (light.pdf + q));
if (max(e.x, max(e.y, e.z)) > 0.0 && meet(p, light.d, light.far, true).what == -1) {
float t_below = ground_at(p, light.d);
float through = ((t_below < light.far) ? (1.0 - ground_share(p + t_below * light.d)) : (1.0));
L += T * e * through;
}
}
}
vec3 wi;
if (test) {
ModelSample s = model_sample(m, wo, u_model);
if (s.pdf <= 0.0) { break; }
wi = s.wi;
pdf = s.pdf;
T *= model_eval(m, wi, wo) * (wi.z / pdf);
} else {
float r = sqrt(u_model.x);
wi = vec3(r * cos(TAU * u_model.y), r * sin(TAU * u_model.y), sqrt(max(1.0 - u_model.x, 1e-12)));
pdf = wi.z / (0.5 * TAU);
T *= grey * 0.5 * TAU;
}
d = normalize(tx * wi.x + ty * wi.y + n * wi.z);
o = p;
float left = max(T.x, max(T.y, T.z));
if (left <= 0.0) { break; }
if (!furnace && b >= 2 && left < 1.0) {
float keep = max(left, 0.05);
if (unit2(uint(4 * b + 4)).x >= keep) { break; }
T /= keep;
}
}
return L;
}
vec4 pixel(uvec2 at) {
pixel_seed = hash(at.x + hash(at.y + hash(uint(U[0].w))));
vec2 q = ((vec2(at) + unit2(0u)) / U[0].xy * 2.0 - 1.0) * vec2(U[2].w, -1.0) * U[1].w;
vec3 L = path(U[1].xyz, normalize(U[4].xyz + q.x * U[2].xyz + q.y * U[3].xyz));
float lum = dot(L, vec3(0.2126, 0.7152, 0.0722));
return vec4(L, lum * lum);
}
`;var wi=`
fn values_at(wi: vec3f, wo: vec3f) -> vec4f {
let m: Model = model_load(P);
return vec4f(model_eval(m, wi, wo), model_pdf(m, wi, wo));
}
fn drawn_at(wo: vec3f, u: vec2f) -> vec4f {
let s: ModelSample = model_sample(model_load(P), wo, u);
return vec4f(s.wi, s.pdf);
}

`,yi=`
vec4 values_at(vec3 wi, vec3 wo) {
Model m = model_load(P);
return vec4(model_eval(m, wi, wo), model_pdf(m, wi, wo));
}
vec4 drawn_at(vec3 wo, vec2 u) {
ModelSample s = model_sample(model_load(P), wo, u);
return vec4(s.wi, s.pdf);
}
`;var bi=`
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

`,$i=`
vec3 texel_of(bool second, int x, int y) {
int k = ((second) ? (1) : (0));
int w = int(D[k].z);
int h = int(D[k].w);
int cx = clamp(x, 0, w - 1);
int cy = clamp(y, 0, h - 1);
return film_at(second, cx, cy, w).rgb * ((second) ? (D[2].y) : (D[2].x));
}
vec3 picture(bool second, vec2 at) {
int k = ((second) ? (1) : (0));
vec2 q = at * D[k].zw - 0.5;
vec2 low = floor(q);
vec2 f = q - low;
int x = int(low.x);
int y = int(low.y);
return mix(mix(texel_of(second, x, y), texel_of(second, x + 1, y), f.x),
mix(texel_of(second, x, y + 1), texel_of(second, x + 1, y + 1), f.x), f.y);
}
vec3 toned(vec3 x) {
int tone = int(D[1].y);
float y = dot(x, vec3(0.2126, 0.7152, 0.0722));
if (tone == 1) { return x * ((1.0 + y / 16.0) / (1.0 + y)); }
if (tone == 2) {
float white = 1.379064;
vec3 v = 2.0 * x;
return white * ((v * (0.15 * v + 0.05) + 0.004) / (v * (0.15 * v + 0.5) + 0.06) - 0.0666667);
}
return x;
}
float encoded(float x) {
float y = clamp(x, 0.0, 1.0);
return ((y < 0.0031308) ? (12.92 * y) : (1.055 * pow(max(y, 1e-9), 1.0 / 2.4) - 0.055));
}
vec4 screen(vec2 at) {
int mode = int(D[0].x);
vec2 place = at;
bool second = mode == 1;
if (mode == 2) { second = at.x > D[0].y; }
if (mode == 3) { second = at.x > 0.5; place.x = fract(at.x * 2.0); }
vec3 x = picture(second, place);
if (mode == 4) { x = 10.0 * abs(picture(true, at) - picture(false, at)); }
else { x = toned(x * D[1].x); }
float noise = fract(52.9829189 * fract(dot(at * 4096.0, vec2(0.06711056, 0.00583715)))) - 0.5;
return vec4(vec3(encoded(x.x), encoded(x.y), encoded(x.z)) + noise / 255.0, 1.0);
}
`;var $e=`#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
`,Ns={wgsl:`fn model_at(uv: vec2f, growth: f32, t: f32) -> Model {
    var m: Model = model_load(P);
`,essl:`Model model_at(vec2 uv, float growth, float t) {
    Model m = model_load(P);
`};function ki(n,t){let e=c=>`uv * ${t==="wgsl"?"vec2f":"vec2"}(${c.scale.map(vn).join(", ")})`,i=n.hooks.find(c=>c.source==="normal_map"),r=i?`2.0 * map_linear(${e(i)}, ${i.layer}).xyz - 1.0`:t==="wgsl"?"vec3f(0.0, 0.0, 1.0)":"vec3(0.0, 0.0, 1.0)",s=t==="wgsl"?`fn normal_at(uv: vec2f) -> vec3f { return ${r}; }
`:`vec3 normal_at(vec2 uv) { return ${r}; }
`,o=n.hooks.filter(c=>c!==i).map(c=>{let l=`m.${c.members[t]}`;if(c.source==="mesh")return`    ${l} = growth;`;if(c.source==="viewer")return`    ${l} = t / ${vn(c.unit)};`;let h=c.source==="flakes"?`map_nearest(uv * ${vn(c.tiles)}, ${c.layer})`:`map_linear(${e(c)}, ${c.layer})`;return`    ${l} = ${h}.${c.width===3?"rgb":"xy"[c.channel]};`});return`${s}${Ns[t]}${o.join(`
`)}
    return m;
}
`}var vn=n=>Number.isInteger(n)?`${n}.0`:String(n),re=(n,t)=>`${n.code[t]}
${n.load[t]}
`,Wt=n=>Math.max(1,n.members.length);function Mi(n){return vi.replace("MEMBERS",Wt(n)).replace("//MODEL",()=>re(n,"wgsl")+ki(n,"wgsl"))}function Ai(n){let t=["nodes","places","looks","alias_table","sky","before"];return`${$e}precision highp sampler2DArray;
uniform vec4 U[44]; uniform vec4 P[${Wt(n)}];
uniform sampler2D ${t.join(", ")}; uniform sampler2DArray maps; out vec4 film;
${Ls}${xi.replace("//MODEL",()=>re(n,"essl")+ki(n,"essl"))}
void main() {
    vec4 old = U[0].z < 0.5 ? vec4(0.0) : texelFetch(before, ivec2(gl_FragCoord.xy), 0);
    film = old + pixel(uvec2(gl_FragCoord.xy));
}`}var Ls=`vec4 row_of(sampler2D table, int i) { return texelFetch(table, ivec2(i & 4095, i >> 12), 0); }
uint reverse_bits(uint x) {
    x = ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    x = ((x & 0x00ff00ffu) << 8) | ((x >> 8) & 0x00ff00ffu);
    return (x << 16) | (x >> 16);
}
`,_i=n=>`@group(0) @binding(0) var<uniform> P: array<vec4f, ${n}>;
@group(0) @binding(1) var<storage, read> given: array<vec4f>;
@group(0) @binding(2) var<storage, read_write> made: array<vec4f>;
`;function Si(n){return`${_i(Wt(n))}${re(n,"wgsl")}${wi}
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if (3u * i + 2u >= arrayLength(&given)) { return; }
    made[2u * i] = values_at(given[3u * i].xyz, given[3u * i + 1u].xyz);
    made[2u * i + 1u] = drawn_at(given[3u * i + 1u].xyz, given[3u * i + 2u].xy);
}`}function zi(n){return`${$e}uniform vec4 P[${Wt(n)}]; uniform sampler2D given;
layout(location = 0) out vec4 made; layout(location = 1) out vec4 drawn;
${re(n,"essl")}${yi}
vec4 row_of(int i) { return texelFetch(given, ivec2(i % 768, i / 768), 0); }
void main() {
    int i = int(gl_FragCoord.y) * 256 + int(gl_FragCoord.x);
    made = values_at(row_of(3 * i).xyz, row_of(3 * i + 1).xyz);
    drawn = drawn_at(row_of(3 * i + 1).xyz, row_of(3 * i + 2).xy);
}`}function Ui(n){return`${_i(Wt(n))}${re(n,"wgsl")}
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&given)) { return; }
    made[id.x] = vec4f(model_albedo(model_load(P), given[id.x].xyz), 0.0);
}`}function Ti(n){return`${$e}uniform vec4 P[${Wt(n)}]; uniform sampler2D given; out vec4 made;
${re(n,"essl")}
void main() { made = vec4(model_albedo(model_load(P), texelFetch(given, ivec2(gl_FragCoord.xy), 0).xyz), 0.0); }`}var Ei=`@group(0) @binding(0) var<uniform> D: array<vec4f, 4>;
@group(0) @binding(1) var<storage, read> film_a: array<vec4f>;
@group(0) @binding(2) var<storage, read> film_b: array<vec4f>;
fn film_at(second: bool, x: i32, y: i32, w: i32) -> vec4f {
    if (second) { return film_b[y * w + x]; }
    return film_a[y * w + x];
}
${bi}
@vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(select(-1.0, 3.0, i == 1u), select(-1.0, 3.0, i == 2u), 0.0, 1.0);
}
@fragment fn pixel(@builtin(position) at: vec4f) -> @location(0) vec4f { return screen(at.xy / D[3].xy); }`,Ii=`${$e}uniform vec4 D[4]; uniform sampler2D film_a, film_b; out vec4 shown;
vec4 film_at(bool second, int x, int y, int w) {
    return second ? texelFetch(film_b, ivec2(x, y), 0) : texelFetch(film_a, ivec2(x, y), 0);
}
${$i}
void main() { shown = screen(vec2(gl_FragCoord.x, D[3].y - gl_FragCoord.y) / D[3].xy); }`,Ci=`${$e}void main() {
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;var Fs=44,Bs=n=>n.filter(t=>t.type==="error").map(t=>`${t.message} (line ${t.lineNum})`)[0],ke=null;async function Rs(){ke??={users:0,coming:Ds()};let n=ke;n.users++;try{return{...await n.coming,taken:n}}catch(t){throw ke=null,t}}async function Ds(){let n=await navigator.gpu.requestAdapter({powerPreference:"high-performance"});if(!n)throw new Error("The browser has WebGPU but no adapter: the driver is blocked or there is no GPU.");let t=Math.min(n.limits.maxStorageBufferBindingSize,1<<30),e=await n.requestDevice({requiredLimits:{maxStorageBufferBindingSize:t,maxBufferSize:Math.min(n.limits.maxBufferSize,1<<30)}});return e.lost.then(()=>{ke=null}),{device:e,adapter:n}}var Ze=class n{name="WebGPU";static async create(){if(!globalThis.isSecureContext)throw new Error("This page came over http:// from another machine, and browsers give WebGPU to secure contexts only.");if(!navigator.gpu)throw new Error("This browser has no WebGPU.");let{device:t,adapter:e,taken:i}=await Rs();return Object.assign(new n(t,e),{taken:i})}constructor(t,e){this.device=t,this.adapter=e.info?.description||e.info?.vendor||"",this.canvas=document.createElement("canvas"),this.context=this.canvas.getContext("webgpu"),this.format=navigator.gpu.getPreferredCanvasFormat(),this.context.configure({device:t,format:this.format,alphaMode:"opaque"}),this.errors=[],t.addEventListener("uncapturederror",l=>this.errors.push(l.error.message)),this.lost=t.lost;let i=l=>({buffer:{type:l}}),r=i("read-only-storage"),s=[i("uniform"),i("uniform"),r,r,r,r,{texture:{sampleType:"unfilterable-float"}},{texture:{sampleType:"unfilterable-float",viewDimension:"2d-array"}},r,i("storage")];this.traceGroup=t.createBindGroupLayout({entries:s.map((l,h)=>({binding:h,visibility:GPUShaderStage.COMPUTE,...l}))}),this.traceLayout=t.createPipelineLayout({bindGroupLayouts:[this.traceGroup]}),this.settings=t.createBuffer({size:16*Fs,usage:GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST}),this.screen=t.createBuffer({size:64,usage:GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST});let o=new Float32Array(8);this.scene={nodes:this.#t(o),places:this.#t(o),looks:this.#t(o)},this.setSky({width:1,height:1,pixels:new Float32Array(4),alias:new Float32Array(4)});let c=t.createShaderModule({code:Ei});this.display=t.createRenderPipeline({layout:"auto",vertex:{module:c,entryPoint:"corner"},fragment:{module:c,entryPoint:"pixel",targets:[{format:this.format}]}})}close(){--this.taken.users===0&&(ke=null,this.device.destroy())}#t(t,e=GPUBufferUsage.STORAGE){let i=this.device.createBuffer({size:Math.max(t.byteLength,16),usage:e|GPUBufferUsage.COPY_DST});return this.device.queue.writeBuffer(i,0,t),i}setScene({nodes:t,places:e,looks:i}){for(let r of Object.values(this.scene))r.destroy();this.scene={nodes:this.#t(t),places:this.#t(e),looks:this.#t(i)}}setSky({width:t,height:e,pixels:i,alias:r}){this.sky?.destroy(),this.alias?.destroy(),this.sky=this.device.createTexture({size:[t,e],format:"rgba32float",usage:GPUTextureUsage.TEXTURE_BINDING|GPUTextureUsage.COPY_DST}),this.device.queue.writeTexture({texture:this.sky},i,{bytesPerRow:16*t},[t,e]),this.alias=this.#t(r)}makeSide(){return{films:[],front:0,width:0,height:0,maps:this.#s({size:1,layers:1,pixels:new Float32Array(4)})}}#s({size:t,layers:e,pixels:i}){let r=this.device.createTexture({size:[t,t,e],format:"rgba32float",usage:GPUTextureUsage.TEXTURE_BINDING|GPUTextureUsage.COPY_DST});return this.device.queue.writeTexture({texture:r},i,{bytesPerRow:16*t,rowsPerImage:t},[t,t,e]),r}setMaps(t,e){t.maps.destroy(),t.maps=this.#s(e)}async compile(t,{trace:e=!0}={}){let[i,r]=await Promise.all([e?this.#e(Mi(t),this.traceLayout):null,this.#e(Si(t))]),s=this.device.createBuffer({size:16*Wt(t),usage:GPUBufferUsage.UNIFORM|GPUBufferUsage.COPY_DST});return{model:t,trace:i,rows:r,params:s}}async#e(t,e="auto"){let i=this.device.createShaderModule({code:t});try{return await this.device.createComputePipelineAsync({layout:e,compute:{module:i,entryPoint:"main"}})}catch(r){throw new Error(Bs((await i.getCompilationInfo()).messages)??r.message)}}forget(t){t.params.destroy()}#i(t,e){let i=e.map((r,s)=>({binding:s,resource:r instanceof GPUBuffer?{buffer:r}:r}));return this.device.createBindGroup({layout:t,entries:i})}resize(t,e,i){t.wanted=[e,i]}trace(t,e,i,r,s,o){let[c,l]=t.wanted,h=1-t.front;(t.films[h]?.width!==c||t.films[h]?.height!==l)&&(t.films[h]?.buffer.destroy(),t.films[h]={width:c,height:l,buffer:this.device.createBuffer({size:16*c*l,usage:GPUBufferUsage.STORAGE|GPUBufferUsage.COPY_SRC})});let u=r[2]>0?t.films[t.front].buffer:this.#r();r[36]=s,r[37]=o,this.device.queue.writeBuffer(this.settings,0,r),this.device.queue.writeBuffer(e.params,0,i);let{nodes:d,places:g,looks:k}=this.scene,v=t.maps.createView({dimension:"2d-array"}),p=this.#i(this.traceGroup,[this.settings,e.params,d,g,k,this.alias,this.sky.createView(),v,u,t.films[h].buffer]),w=this.device.createCommandEncoder(),b=w.beginComputePass();return b.setPipeline(e.trace),b.setBindGroup(0,p),b.dispatchWorkgroups(Math.ceil(c/8),Math.ceil((o-s)/8)),b.end(),this.device.queue.submit([w.finish()]),this.device.queue.onSubmittedWorkDone()}#r(){return this.empty??=this.#t(new Float32Array(4))}swap(t){t.front=1-t.front,Object.assign(t,{width:t.films[t.front].width,height:t.films[t.front].height})}show(t,e,i){let r=c=>c?.films[c.front]?.buffer;if(!r(t))return;this.device.queue.writeBuffer(this.screen,0,i);let s=this.device.createCommandEncoder(),o=s.beginRenderPass({colorAttachments:[{view:this.context.getCurrentTexture().createView(),loadOp:"clear",storeOp:"store"}]});o.setPipeline(this.display),o.setBindGroup(0,this.#i(this.display.getBindGroupLayout(0),[this.screen,r(t),r(e)??r(t)])),o.draw(3),o.end(),this.device.queue.submit([s.finish()])}async#n(t,e){let i=this.device.createBuffer({size:e,usage:GPUBufferUsage.COPY_DST|GPUBufferUsage.MAP_READ}),r=this.device.createCommandEncoder();r.copyBufferToBuffer(t,0,i,0,e),this.device.queue.submit([r.finish()]),await i.mapAsync(GPUMapMode.READ);let s=new Float32Array(i.getMappedRange().slice(0));return i.destroy(),s}readFilm(t){let e=t.films[t.front];return this.#n(e.buffer,16*e.width*e.height)}async#c(t,e,i,r,s,o){this.device.queue.writeBuffer(e,0,i);let c=this.#t(r),l=this.device.createBuffer({size:16*o,usage:GPUBufferUsage.STORAGE|GPUBufferUsage.COPY_SRC}),h=this.device.createCommandEncoder(),u=h.beginComputePass();u.setPipeline(t),u.setBindGroup(0,this.#i(t.getBindGroupLayout(0),[e,c,l])),u.dispatchWorkgroups(Math.ceil(s/64)),u.end(),this.device.queue.submit([h.finish()]);let d=await this.#n(l,16*o);return c.destroy(),l.destroy(),d}rows(t,e,i){let r=i.length/12;return this.#c(t.rows,t.params,e,i,r,2*r)}async albedo(t,e,i){return t.albedo??=await(t.albedoComing??=this.#e(Ui(t.model))),this.#c(t.albedo,t.params,e,i,i.length/4,i.length/4)}};var Oi=4096,We=class n{name="WebGL2";static async create(){return new n}constructor(){this.canvas=document.createElement("canvas");let t=this.gl=this.canvas.getContext("webgl2",{antialias:!1,alpha:!1,preserveDrawingBuffer:!0,powerPreference:"high-performance"});if(!t)throw new Error("This browser has neither WebGPU nor WebGL2.");if(!t.getExtension("EXT_color_buffer_float"))throw new Error("This GPU cannot draw into float textures (EXT_color_buffer_float).");this.parallel=t.getExtension("KHR_parallel_shader_compile"),this.adapter=t.getParameter(t.RENDERER),this.lost=new Promise(i=>this.canvas.addEventListener("webglcontextlost",r=>{r.preventDefault(),i({message:"The WebGL context was lost.",reason:this.closed?"destroyed":"unknown"})})),t.bindVertexArray(t.createVertexArray()),this.errors=[],this.frame=t.createFramebuffer(),this.corner=this.#t(t.VERTEX_SHADER,Ci),this.display=this.#s(this.#t(t.FRAGMENT_SHADER,Ii)),this.#e(this.display);let e=new Float32Array(8);this.setScene({nodes:e,places:e,looks:e}),this.setSky({width:1,height:1,pixels:new Float32Array(4),alias:new Float32Array(4)})}close(){this.closed=!0,this.gl.getExtension("WEBGL_lose_context")?.loseContext()}#t(t,e){let i=this.gl.createShader(t);return this.gl.shaderSource(i,e),this.gl.compileShader(i),i}#s(t){let e=this.gl,i=e.createProgram();return e.attachShader(i,this.corner),e.attachShader(i,t),e.linkProgram(i),{program:i,fragment:t,places:new Map}}#e(t){let e=this.gl;if(e.getProgramParameter(t.program,e.LINK_STATUS))return t;throw new Error((e.getShaderInfoLog(t.fragment)||e.getProgramInfoLog(t.program)||"The shader does not compile.").trim().split(`
`)[0])}async#i(t){let e=this.gl;if(this.parallel)for(;!e.isContextLost()&&!e.getProgramParameter(t.program,this.parallel.COMPLETION_STATUS_KHR);)await new Promise(i=>setTimeout(i,8));return this.#e(t)}#r(t,e){return t.places.has(e)||t.places.set(e,this.gl.getUniformLocation(t.program,e)),t.places.get(e)}#n(t,e,i){let r=this.gl,s=r.createTexture();return r.bindTexture(r.TEXTURE_2D,s),r.texStorage2D(r.TEXTURE_2D,1,r.RGBA32F,t,e),i&&r.texSubImage2D(r.TEXTURE_2D,0,0,0,t,e,r.RGBA,r.FLOAT,i),this.#c(r.TEXTURE_2D),s}#c(t){let e=this.gl;e.texParameteri(t,e.TEXTURE_MIN_FILTER,e.NEAREST),e.texParameteri(t,e.TEXTURE_MAG_FILTER,e.NEAREST)}#p(t){let e=Math.max(1,t.length/4),i=Oi,r=Math.ceil(e/Oi),s=new Float32Array(4*i*r);return s.set(t),this.#n(i,r,s)}setScene(t){for(let e of["nodes","places","looks"])this.gl.deleteTexture(this[e]),this[e]=this.#p(t[e])}setSky({width:t,height:e,pixels:i,alias:r}){this.gl.deleteTexture(this.sky),this.gl.deleteTexture(this.alias_table),this.sky=this.#n(t,e,i),this.alias_table=this.#p(r)}makeSide(){return{films:[],front:0,width:0,height:0,maps:this.#l({size:1,layers:1,pixels:new Float32Array(4)})}}#l({size:t,layers:e,pixels:i}){let r=this.gl,s=r.createTexture();return r.bindTexture(r.TEXTURE_2D_ARRAY,s),r.texImage3D(r.TEXTURE_2D_ARRAY,0,r.RGBA32F,t,t,e,0,r.RGBA,r.FLOAT,i),this.#c(r.TEXTURE_2D_ARRAY),s}setMaps(t,e){this.gl.deleteTexture(t.maps),t.maps=this.#l(e)}async compile(t,{trace:e=!0}={}){let i=o=>this.#s(this.#t(this.gl.FRAGMENT_SHADER,o)),r=e?i(Ai(t)):null,s=i(zi(t));return{model:t,trace:r&&await this.#i(r),rows:await this.#i(s)}}forget(t){for(let e of[t.trace,t.rows,t.albedo])e&&this.gl.deleteProgram(e.program)}resize(t,e,i){t.wanted=[e,i]}#h(t,e){let i=this.gl;i.useProgram(t.program),Object.entries(e).forEach(([r,s],o)=>{i.activeTexture(i.TEXTURE0+o),i.bindTexture(r==="maps"?i.TEXTURE_2D_ARRAY:i.TEXTURE_2D,s),i.uniform1i(this.#r(t,r),o)})}async trace(t,e,i,r,s,o){let c=this.gl,[l,h]=t.wanted,u=1-t.front;(t.films[u]?.width!==l||t.films[u]?.height!==h)&&(c.deleteTexture(t.films[u]?.texture??null),t.films[u]={width:l,height:h,texture:this.#n(l,h,null)});let d=r[2]>0?t.films[t.front].texture:this.empty??=this.#n(1,1,new Float32Array(4)),{nodes:g,places:k,looks:v,alias_table:p,sky:w}=this;this.#h(e.trace,{nodes:g,places:k,looks:v,alias_table:p,sky:w,maps:t.maps,before:d}),c.uniform4fv(this.#r(e.trace,"U"),r),c.uniform4fv(this.#r(e.trace,"P"),i),this.#o([t.films[u].texture],l,h),c.enable(c.SCISSOR_TEST),c.scissor(0,s,l,o-s),c.drawArrays(c.TRIANGLES,0,3),c.disable(c.SCISSOR_TEST),await this.#f()}#o(t,e,i){let r=this.gl;r.bindFramebuffer(r.FRAMEBUFFER,this.frame);for(let s=0;s<2;s++)r.framebufferTexture2D(r.FRAMEBUFFER,r.COLOR_ATTACHMENT0+s,r.TEXTURE_2D,t[s]??null,0);r.drawBuffers(t.map((s,o)=>r.COLOR_ATTACHMENT0+o)),r.viewport(0,0,e,i)}async#f(){let t=this.gl,e=t.fenceSync(t.SYNC_GPU_COMMANDS_COMPLETE,0);for(t.flush();!t.isContextLost();){let i=t.clientWaitSync(e,0,0);if(i===t.ALREADY_SIGNALED||i===t.CONDITION_SATISFIED)break;await new Promise(r=>setTimeout(r,1))}t.deleteSync(e)}swap(t){t.front=1-t.front,Object.assign(t,{width:t.films[t.front].width,height:t.films[t.front].height})}show(t,e,i){let r=this.gl,s=o=>o?.films[o.front]?.texture;s(t)&&(r.bindFramebuffer(r.FRAMEBUFFER,null),r.viewport(0,0,this.canvas.width,this.canvas.height),this.#h(this.display,{film_a:s(t),film_b:s(e)??s(t)}),r.uniform4fv(this.#r(this.display,"D"),i),r.drawArrays(r.TRIANGLES,0,3))}async readFilm(t){let e=t.films[t.front];return this.#o([e.texture],e.width,e.height),this.#a(0,e.width,e.height)}#a(t,e,i){let r=this.gl,s=new Float32Array(4*e*i);return r.readBuffer(r.COLOR_ATTACHMENT0+t),r.readPixels(0,0,e,i,r.RGBA,r.FLOAT,s),s}async rows(t,e,i){let r=this.gl,s=i.length/12,o=Math.ceil(s/256),c=new Float32Array(4*768*o);c.set(i);let l=this.#n(768,o,c),h=this.#n(256,o),u=this.#n(256,o);this.#h(t.rows,{given:l}),r.uniform4fv(this.#r(t.rows,"P"),e),this.#o([h,u],256,o),r.drawArrays(r.TRIANGLES,0,3),await this.#f(),this.#o([h,u],256,o);let d=this.#a(0,256,o),g=this.#a(1,256,o),k=new Float32Array(8*s);for(let v=0;v<s;v++)k.set(d.subarray(4*v,4*v+4),8*v),k.set(g.subarray(4*v,4*v+4),8*v+4);for(let v of[l,h,u])r.deleteTexture(v);return k}async albedo(t,e,i){t.albedo??=await(t.albedoComing??=this.#i(this.#s(this.#t(this.gl.FRAGMENT_SHADER,Ti(t.model)))));let r=this.gl,s=i.length/4,o=this.#n(s,1,i),c=this.#n(s,1);this.#h(t.albedo,{given:o}),r.uniform4fv(this.#r(t.albedo,"P"),e),this.#o([c],s,1),r.drawArrays(r.TRIANGLES,0,3),await this.#f(),this.#o([c],s,1);let l=this.#a(0,s,1);return r.deleteTexture(o),r.deleteTexture(c),l}};var Pi=220,Hs=12,Gs=90,qs=8,Zs=1.14;async function wn(n=""){let t="";if(n!=="webgl2")try{return{gpu:await Ze.create(),reason:t}}catch(e){t=e.message}return{gpu:await We.create(),reason:t}}function xn(n,t){let e=Bt(n.positions,Uint16Array),i=Bt(n.normals,Int16Array),r=Bt(n.uvs,Int16Array);return{kind:t,faces:Bt(n.faces,Uint16Array),positions:Float32Array.from(e,(s,o)=>n.low[o%3]+s/65535*(n.high[o%3]-n.low[o%3])),normals:Float32Array.from(i,s=>s/32767),uvs:Float32Array.from(r,s=>s/32767*n.uv_reach),growth:n.growth?Float32Array.from(Bt(n.growth,Uint8Array),s=>s/255):null}}var je=class{constructor(t,e,i){this.gpu=t,this.start=e,this.changed=i,this.sides=[],this.limit=256,this.size=[300,200],this.ms=0,this.epoch=0,this.movedAt=-1/0,this.own=null,this.sky=null,this.scenes=new Map,this.rate=400,this.settings=null}replace(t){this.gpu=t,this.sceneName=this.skyName="";for(let e of this.sides)e.film=null,e.program=null,e.samples=0}light(t){if(t.env==="own"&&this.sky){let{fade:i}=this.start,r=t.turn-t.az;return this.sky.groundFor!==r&&Object.assign(this.sky,{groundFor:r,ground:ai(this.sky,r,i)}),{lamps:[],surround:[0,0,0],picture:this.sky,ground:null,fade:i.radii,groundColour:this.sky.ground,turn:t.turn}}let e=this.start.environments[t.env]??this.start.environments.studio;return{...e,fade:e.groundColour?this.start.fade.radii:[0,0],turn:t.turn}}#t(t,e){let i=t.furnace,r=t.shape==="own"&&!this.own?"ball":t.shape,s=`${r}/${i?"none":e.ground}/${this.own?.id}`;if(!this.scenes.has(s)){let{shapes:c}=this.start,l=[],h=null;r==="ball"?(l.push(xn(c.shell,0)),h=c.core,i||l.push(xn(c.pedestal,2))):r==="sphere"?h={centre:[0,i?1.2:1,0],radius:1}:l.push(this.own.mesh),!i&&e.ground&&l.push(xn(c.grounds[e.ground],1)),this.scenes.size>6&&this.scenes.clear(),this.scenes.set(s,{...hi(l),core:h,name:s})}let o=this.scenes.get(s);return this.sceneName!==s&&(this.gpu.setScene(o),this.sceneName=s),o}#s(t){if(!t.picture)return null;if(!t.picture.pixels){let{width:e,height:i,half:r}=t.picture,s=qe(Bt(r,Uint16Array)),o=new Float32Array(4*e*i);for(let c=0;c<e*i;c++)o.set(s.subarray(3*c,3*c+3),4*c);t.picture.pixels=o}return t.picture.alias??=si(t.picture.pixels,t.picture.width,t.picture.height),t.picture.id??=crypto.randomUUID?.()??String(Math.random()),this.skyName!==t.picture.id&&(this.gpu.setSky(t.picture),this.skyName=t.picture.id),t.picture}lightDirection(t,e){let i=this.light(t),r=t.turn*Math.PI/180,s=([o,c,l])=>[Math.cos(r)*o+Math.sin(r)*l,c,Math.cos(r)*l-Math.sin(r)*o];if(i.lamps.length){let o=l=>l.radiance[1]*l.area/Math.hypot(...l.centre)**2,c=i.lamps.reduce((l,h)=>o(h)>o(l)?h:l);return s(c.centre).map((l,h)=>l-e[h])}return i.picture?(this.#s(i),s(oi(i.picture.pixels,i.picture.width,i.picture.height))):[.4,1,.5]}target(t){return t.shape==="sphere"?[0,t.furnace?1.2:1,0]:t.shape==="own"&&this.own?[0,this.own.height/2,0]:[0,t.furnace?1.2:Zs,0]}view(t,e,i){return pi({azimuth:t.az,elevation:t.el,distance:t.dist,target:this.target(t)},e,i)}pictureSize(t=this.settings){let[e,i]=this.size;return t.cmp==="side"&&this.sides.length>1?[Math.floor(e/2),i]:[e,i]}restart(t,{moving:e=!0}={}){this.settings=t,this.epoch++,this.movedAt=e?performance.now():-1/0,this.#e?.()}refresh(t){this.settings=t,this.show(),this.#e?.()}#e=null;visible(){let{cmp:t}=this.settings,e=this.sides.filter(i=>i.program);return t==="A"||this.sides.length<2?e.slice(0,1):t==="B"?e.slice(1):e}show(){let[t,e]=this.sides,i=this.settings;if(!i)return;let r=t?.film?.width?t:e;if(!r?.film?.width)return;let s=e?.film?.width?e:r,o=l=>({width:l.film.width,height:l.film.height,samples:Math.max(1,l.shown)}),c=this.sides.length<2?"A":i.cmp==="flick"?this.flicker?"B":"A":i.cmp;this.gpu.show(r.film,s.film,gi({canvas:this.gpu.canvas,mode:c,wipe:i.wipe,exposure:i.ev,tone:i.tone,a:o(r),b:o(s)}))}async run(){for(;!this.closed;){let t=performance.now(),e=!!this.settings&&t-this.movedAt<Pi,i=this.settings?this.visible():[],r=e?this.#i(i.length):1,s=i.filter(h=>h.epoch!==this.epoch||h.scale!==r||h.samples<(e?4:this.limit));if(!s.length||this.paused){let h=e?Pi-(t-this.movedAt)+1:0;await new Promise(u=>{this.#e=u,(h>0||this.paused)&&setTimeout(u,this.paused?200:h)});continue}let o=Math.min(...s.map(h=>h.epoch===this.epoch&&h.scale===r?h.samples:0)),c=s.filter(h=>h.epoch!==this.epoch||h.scale!==r||h.samples===o),l=[];try{for(let h of c){let u=await this.#r(h,r,e);if(!u)break;l.push(u)}l.length===c.length&&this.#n(l)}catch(h){this.closed||this.failed?.(h),await new Promise(u=>setTimeout(u,500))}}}#i(t){let[e,i]=this.pictureSize(),r=this.coarse??4,s=Math.sqrt(e*i*t/(this.rate*Gs));return this.coarse=Math.min(qs,Math.max(2,s>r*1.3||s<r*.6?Math.ceil(s):r)),this.coarse}async#r(t,e,i){let{epoch:r,settings:s}=this,{program:o}=t,c=this.light(s),l=this.#s(c),h=this.#t(s,c),[u,d]=this.pictureSize(s).map(b=>Math.max(1,Math.floor(b/e))),g=t.epoch!==r||t.scale!==e||t.film?.wanted?.[0]!==u||t.film?.wanted?.[1]!==d;t.film??=this.gpu.makeSide(),(t.mapsOf!==t.payload||t.mapsOn!==t.film)&&(t.mapData=t.maps(),this.gpu.setMaps(t.film,t.mapData),t.mapsOf=t.payload,t.mapsOn=t.film),g&&this.gpu.resize(t.film,u,d);let k=g?0:t.samples,v=mi({width:u,height:d,sample:k,view:this.view(s,u,d),light:{...c,picture:l},furnace:s.furnace,scene:h,estimator:this.estimator??"both"}),p=t.packed(),w=0;for(let b=0;b<d;){let A=Math.max(8,Math.round(this.rate*Hs/u/8)*8),T=Math.min(d,b+A),B=performance.now();await this.gpu.trace(t.film,o,p,v,b,T);let W=Math.max(performance.now()-B,.2);if(w+=W,this.rate+=.3*(Math.min(u*(T-b)/W,1e6)-this.rate),b=T,this.closed||t.program!==o||!i&&this.epoch!==r)return null}return{side:t,epoch:r,scale:e,samples:k+1,spent:w}}#n(t){for(let{side:e,epoch:i,scale:r,samples:s}of t)this.gpu.swap(e.film),Object.assign(e,{epoch:i,scale:r,samples:s,shown:s});this.begun||performance.mark("gonio-picture"),this.begun=!0,this.ms=t.reduce((e,{spent:i})=>e+i,0),this.show(),this.changed(t[0].side)}async statistics(){let t=[];for(let s of this.visible()){if(!s.film?.width||s.shown<2)return null;t.push({side:s,n:s.shown,width:s.film.width,data:await this.gpu.readFilm(s.film)})}let e=(s,o)=>.2126*s[o]+.7152*s[o+1]+.0722*s[o+2],i=t.map(({side:s,n:o,data:c})=>{let l=0,h=0;for(let d=0;d<c.length;d+=4){let g=e(c,d)/o;l+=g,h+=Math.sqrt(Math.max(0,c[d+3]/o-g*g)/o)}let u=c.length/4;return{letter:s.letter,mean:l/u,noise:h/Math.max(l,1e-9)}}),r=null;if(t.length===2&&t[0].data.length===t[1].data.length){let s=0,[o,c]=t;for(let l=0;l<o.data.length;l+=4)for(let h=0;h<3;h++)s+=(o.data[l+h]/o.n-c.data[l+h]/c.n)**2;r=Math.sqrt(s/(.75*o.data.length))}return{sides:i,rmse:r}}close(){this.closed=!0,this.#e?.(),this.gpu.close()}};var Me=n=>String(Number(n.toPrecision(9))),Ni=n=>Array.isArray(n)?n.every(t=>t===n[0])?Me(n[0]):n.map(Me).join("/"):typeof n=="number"?Me(n):n,Ae=class{constructor(t){this.letter=t,this.payload=null,this.values=new Map,this.samples=0,this.error="",this.busy="",this.hidden=new Set,this.active=null}take(t){this.payload=t,this.values=new Map(t.parameters.map(e=>[e.path,e.value.slice()])),this.options=new Map(t.options.map(e=>[e.path,e.value])),this.models=new Map(t.models.map(e=>[e.path,e.value]))}parameter(t){return this.payload.parameters.find(e=>e.path===t)}startOf(t,e){let i=this.payload.start[t],r=t.lastIndexOf(".");for(let o=t.slice(0,Math.max(r,0));o;o=o.slice(0,Math.max(o.lastIndexOf("."),0)))if(this.models.get(o)!==this.payload.start[o])return e;if(i===void 0)return e;let s=Array.isArray(e)?e.length:0;return s?Array.isArray(i)?i:Array(s).fill(i):i}changed(t){let e=this.parameter(t),i=e?this.startOf(t,e.default):null;return e?this.values.get(t).some((r,s)=>Me(r)!==Me(i[s])):!1}text(t={}){let e=[],i=r=>Object.keys(t).some(s=>r.startsWith(`${s}.`)&&this.models.has(s)&&t[s]!==this.models.get(s));for(let[r,s]of this.models){let o=t[r]??s,c=this.payload.models.find(l=>l.path===r);!i(r)&&o!==this.startOf(r,c.default)&&e.push(`${r}=${o}`)}for(let r of this.payload.options){let s=t[r.path]??this.options.get(r.path);!i(r.path)&&s!==this.startOf(r.path,r.default)&&e.push(`${r.path}=${s}`)}for(let r of this.payload.parameters)!i(r.path)&&this.changed(r.path)&&e.push(`${r.path}=${Ni(this.values.get(r.path))}`);return this.payload.name+(e.length?`:${e.join(",")}`:"")}plainText(){let{payload:t}=this;if(t.name===t.model||t.name.endsWith(".py"))return this.text();if(this.text()===t.name&&t.plain)return t.name;let e=t.models.filter(i=>this.models.get(i.path)!==i.default).map(i=>`${i.path}=${this.models.get(i.path)}`);for(let i of t.options)this.options.get(i.path)!==i.default&&e.push(`${i.path}=${this.options.get(i.path)}`);for(let i of t.parameters)this.values.get(i.path).some((r,s)=>r!==i.default[s])&&e.push(`${i.path}=${Ni(this.values.get(i.path))}`);return t.model+(e.length?`:${e.join(",")}`:"")}packed(t={}){let{members:e}=this.active.payload,i=new Float32Array(4*Math.max(1,e.length));return e.map(this.active.path).forEach((r,s)=>i.set(t[r]??this.values.get(r),4*s)),i}maps(){let{maps:t}=this.payload;if(!t)return{size:1,layers:1,pixels:new Float32Array(4)};let e=qe(Bt(t.half,Uint16Array)),i=e.length/t.channels,r=new Float32Array(4*i);for(let s=0;s<i;s++)for(let o=0;o<t.channels;o++)r[4*s+o]=e[t.channels*s+o];return{size:t.size,layers:t.layers,pixels:r}}overrides(t,e,i,r){let s={};for(let o of this.payload.hooks)if(o.source==="mesh")s[o.path]=[e];else if(o.source==="viewer")s[o.path]=[i/o.unit];else if(o.source!=="normal_map"){let c=o.source==="flakes"?[o.tiles,o.tiles]:o.scale,{size:l,pixels:h}=r,u=t.map((b,A)=>b*c[A]*l-(o.source==="flakes"?0:.5)),d=(b,A,T)=>h[4*((o.layer*l+(A%l+l)%l)*l+(b%l+l)%l)+T],[g,k]=u.map(Math.floor),[v,p]=[u[0]-g,u[1]-k],w=b=>o.source==="flakes"?d(g,k,b):(1-p)*((1-v)*d(g,k,b)+v*d(g+1,k,b))+p*((1-v)*d(g,k+1,b)+v*d(g+1,k+1,b));s[o.path]=o.width===3?[w(0),w(1),w(2)]:[w(o.channel)]}return s}};var se={a:"",b:"",cmp:"A",wipe:.5,env:"studio",turn:0,ev:0,tone:"none",furnace:!1,shape:"ball",view:"picture",az:0,el:13,dist:9.6,theta:45,layer:0,probe:"",dock:"plots",edit:"A"},Li=n=>typeof se[n]=="number";function Ve(n){let t=[];for(let[e,i]of Object.entries(se)){let r=n[e];if(r===i&&!(e==="cmp"&&n.b)||e==="edit")continue;let s=Li(e)?String(Math.round(r*1e4)/1e4):r===!0?"1":r;t.push(`${e}=${encodeURIComponent(s).replace(/%3A/g,":").replace(/%3D/g,"=").replace(/%2C/g,",").replace(/%2F/g,"/")}`)}return t.join("&")}function Ke(n){let t={},e=[];for(let i of n.replace(/^#/,"").split("&").filter(Boolean)){let r=i.indexOf("="),s=r<0?i:i.slice(0,r),o="";try{o=decodeURIComponent(r<0?"":i.slice(r+1))}catch{e.push(s);continue}if(s!=="token"){if(!(s in se)){e.push(s);continue}if(Li(s)){if(o.trim()===""||!Number.isFinite(Number(o))){e.push(s);continue}o=Number(o)}else typeof se[s]=="boolean"&&(o=o==="1");t[s]=o}}return{state:t,bad:e}}var Ye=class{constructor(t){this.steps=[JSON.stringify(t)],this.at=0,this.name=""}add(t,e){let i=JSON.stringify(t),r=Date.now();i!==this.steps[this.at]&&(e&&e===this.name&&r-this.when<1e3?this.steps[this.at]=i:(this.steps.splice(++this.at,1/0,i),this.steps.length>200&&(this.steps.shift(),this.at--)),this.name=e,this.when=r)}step(t){return this.can(t)?(this.at+=t,this.name="",JSON.parse(this.steps[this.at])):null}can(t){return this.at+t>=0&&this.at+t<this.steps.length}};var ee=Math.PI/180,oe=(n,t=0)=>[Math.sin(n)*Math.cos(t),Math.sin(n)*Math.sin(t),Math.cos(n)];function _e(n){let t=new Float32Array(12*n.length);return n.forEach(([e,i,r=[.5,.5]],s)=>{t.set(e,12*s),t.set(i,12*s+4),t.set(r,12*s+8)}),t}function Ws(n){let t=new Set;for(let e=-90;e<=90;e+=1.5)t.add(e);for(let e=0,i=.02;e<26;e++,i*=1.3)for(let r of[n-i,n+i])Math.abs(r)<90&&t.add(r);return t.add(n),[...t].sort((e,i)=>e-i)}var yn=Array.from({length:61},(n,t)=>Math.min(1.5*t,89.9)),jt=44;function js(n,t){let e=oe(t,Math.PI/2),[i,r]=[Math.cos(n),Math.sin(n)],s=[i*e[0]+r*e[2],e[1],i*e[2]-r*e[0]],o=[r,0,i],c=2*(s[0]*o[0]+s[1]*o[1]+s[2]*o[2]),l=s.map((h,u)=>c*o[u]-h);return s[2]>0&&l[2]>0?[s,l]:null}async function Fi(n,t,e){let{program:i}=t,r=t.packed(),s=oe(e*ee,Math.PI),o=Ws(e),c=[];for(let v=0;v<jt;v++)for(let p=0;p<jt;p++)c.push(js((p+.5)/jt*90*ee,(1-(v+.5)/jt)*90*ee));let l=[...o.map(v=>[oe(v*ee),s]),...c.map(v=>v??[[0,0,-1],[0,0,1]])],h=await n.rows(i,r,_e(l)),u=o.map((v,p)=>({angle:v,f:[...h.subarray(8*p,8*p+3)],pdf:h[8*p+3]})),d=c.map((v,p)=>v?[...h.subarray(8*(o.length+p),8*(o.length+p)+3)]:null),g=new Float32Array(4*yn.length);yn.forEach((v,p)=>g.set(oe(v*ee),4*p));let k=await n.albedo(i,r,g);return{thetaO:e,slice:u,map:d,albedo:yn.map((v,p)=>({angle:v,value:[...k.subarray(4*p,4*p+3)]}))}}function Ys(n,t,e){let i=oe(n*ee),r=[i[2],0,-i[0]],s=[0,1,0],o=[];for(let c=0;c<=t;c++){let l=Math.PI*(c/t)**3;for(let h=0;h<e;h++){let u=2*Math.PI*h/e,[d,g]=[Math.cos(l),Math.sin(l)],k=i.map((p,w)=>d*p+g*(Math.cos(u)*r[w]+Math.sin(u)*s[w]));k[2]=Math.max(k[2],1e-4);let v=Math.hypot(...k);o.push(k.map(p=>p/v))}}return o}async function Bi(n,t,e,i=40,r=60,s=600){let o=oe(e*ee,Math.PI),c=Ys(e,i,r),l=c.map(p=>[p,o]);for(let p=0;p<s;p++)l.push([[0,0,1],o,[(p+.5)*.7548776662%1,(p+.5)*.5698402909%1]]);let h=t.packed(),u=await n.rows(t.program,h,_e(l)),d=c.map((p,w)=>[...u.subarray(8*w,8*w+3)]),g=Array.from({length:s},(p,w)=>[...u.subarray(8*(c.length+w)+4,8*(c.length+w)+8)]),k=await n.rows(t.program,h,_e(g.map(p=>[p[3]>0?p.slice(0,3):[0,0,1],o]))),v=g.map((p,w)=>({wi:p.slice(0,3),pdf:p[3],f:[...k.subarray(8*w,8*w+3)]})).filter(p=>p.pdf>0);for(let p of v)p.weight=p.f.map(w=>w*p.wi[2]/p.pdf);return{thetaO:e,grid:c,f:d,rings:i,segments:r,points:v,wasted:s-v.length}}function Ri(n,t){let e=new Uint8Array(n),i=0,r=()=>{let g="";for(;i<e.length&&e[i]!==10;)g+=String.fromCharCode(e[i++]);return i++,g.trim()};if(!/^#\?(RADIANCE|RGBE)/.test(r()))throw new Error("Its first line is not #?RADIANCE.");let s="";for(let g=r();g&&(g.startsWith("FORMAT=")&&(s=g.slice(7)),!(i>=e.length));g=r());if(s&&s!=="32-bit_rle_rgbe")throw new Error(`Its format is ${s}; the page reads 32-bit_rle_rgbe.`);let o=/^([-+])Y (\d+) ([-+])X (\d+)$/.exec(r());if(!o)throw new Error("The line with its size cannot be read.");let c=Number(o[2]),l=Number(o[4]);if(l*c>t||!l||!c)throw new Error(`It has ${(l*c).toLocaleString("en")} pixels; the page takes ${t.toLocaleString("en")}.`);let h=new Float32Array(4*l*c),u=new Uint8Array(4*l),d=()=>new Error("The file ends too early.");for(let g=0;g<c;g++){if(i+4>e.length)throw d();if(l>=8&&l<32768&&e[i]===2&&e[i+1]===2&&(e[i+2]<<8|e[i+3])===l){i+=4;for(let v=0;v<4;v++)for(let p=0;p<l;){if(i>=e.length)throw d();let w=e[i++],b=w>128;if(b&&(w-=128),!w||p+w>l||i+(b?1:w)>e.length)throw new Error("Its runs are damaged.");if(b)for(let A=e[i++];w--;)u[4*p+++v]=A;else for(;w--;)u[4*p+++v]=e[i++]}}else{if(i+4*l>e.length)throw d();u.set(e.subarray(i,i+4*l)),i+=4*l}let k=o[1]==="-"?g:c-1-g;for(let v=0;v<l;v++){let p=u[4*v+3]?2**(u[4*v+3]-136):0,w=4*(k*l+(o[3]==="+"?v:l-1-v));for(let b=0;b<3;b++)h[w+b]=u[4*v+b]*p}}return{width:l,height:c,pixels:h}}function Di(n,t){let e=[],i=[],r=[],s=[],o=[],c=[],l=[],h=new Map,u=!0,d=!0,g=0,k=v=>{if(h.has(v))return h.get(v);let[p,w,b]=v.split("/").map(I=>I?Number(I):0),A=(I,G,Y)=>I<0?G.length/Y+I:I-1,T=A(p,e,3);if(!Number.isInteger(p)||p===0||T<0||3*T>=e.length)throw new Error(`Line ${g} names a point that does not exist.`);s.push(e[3*T],e[3*T+1],e[3*T+2]);let B=w?2*A(w,i,2):-1,W=b?3*A(b,r,3):-1;return B>=0&&B+1<i.length?o.push(i[B],1-i[B+1]):(o.push(0,0),d=!1),W>=0&&W+2<r.length?c.push(r[W],r[W+1],r[W+2]):(c.push(0,0,0),u=!1),h.set(v,s.length/3-1),s.length/3-1};for(let v of n.split(`
`)){g++;let p=v.trim().split(/\s+/),w=b=>{for(let A=1;A<=b;A++)if(!Number.isFinite(Number(p[A])))throw new Error(`Line ${g} is no list of numbers.`);return p.slice(1,b+1).map(Number)};if(p[0]==="v")e.push(...w(3));else if(p[0]==="vt")i.push(...w(2));else if(p[0]==="vn")r.push(...w(3));else if(p[0]==="f"){let b=p.slice(1).map(k);for(let A=2;A<b.length;A++)l.push(b[0],b[A-1],b[A]);if(l.length/3>t)throw new Error(`It has more than ${t.toLocaleString("en")} triangles, which is what the page takes.`)}}if(!l.length)throw new Error("It has no faces.");return{positions:Float32Array.from(s),faces:Uint32Array.from(l),uvs:d?Float32Array.from(o):null,normals:u?Vs(c):null}}function Vs(n){let t=Float32Array.from(n);for(let e=0;e<t.length;e+=3){let i=Math.hypot(t[e],t[e+1],t[e+2])||1;for(let r=0;r<3;r++)t[e+r]/=i}return t}var Ks={5120:Int8Array,5121:Uint8Array,5122:Int16Array,5123:Uint16Array,5125:Uint32Array,5126:Float32Array},Js={SCALAR:1,VEC2:2,VEC3:3,VEC4:4};function Hi(n,t){let e=new DataView(n);if(n.byteLength<20||e.getUint32(0,!0)!==1179937895)throw new Error("It does not begin as a binary glTF file does.");if(e.getUint32(4,!0)!==2)throw new Error(`It is glTF version ${e.getUint32(4,!0)}; the page reads version 2.`);let i=null,r=null;for(let v=12;v+8<=n.byteLength;){let p=e.getUint32(v,!0),w=e.getUint32(v+4,!0);if(v+8+p>n.byteLength)throw new Error("The file ends too early.");if(w===1313821514)try{i=JSON.parse(new TextDecoder().decode(new Uint8Array(n,v+8,p)))}catch{throw new Error("Its description is no JSON.")}w===5130562&&(r=n.slice(v+8,v+8+p)),v+=8+p}if(!i||!r)throw new Error("It lacks its description or its data.");let s=(i.extensionsRequired??[]).filter(v=>v!=="KHR_mesh_quantization"&&!v.startsWith("KHR_materials"));if(s.length)throw new Error(`It needs ${s.join(", ")}, which the page does not read.`);let o={positions:[],normals:[],uvs:[],faces:[]},c=!0,l=!0,h=v=>{let p=i.accessors?.[v],w=i.bufferViews?.[p?.bufferView],b=Ks[p?.componentType],A=Js[p?.type];if(!p||!w||!b||!A||w.buffer)throw new Error("Its data cannot be found.");let T=(w.byteOffset??0)+(p.byteOffset??0),B=w.byteStride??A*b.BYTES_PER_ELEMENT,W=new Float64Array(p.count*A),I=new DataView(r);if(T+B*(p.count-1)+A*b.BYTES_PER_ELEMENT>r.byteLength)throw new Error("The file ends too early.");let G={5120:"getInt8",5121:"getUint8",5122:"getInt16",5123:"getUint16",5125:"getUint32",5126:"getFloat32"}[p.componentType],Y=p.normalized?{5120:127,5121:255,5122:32767,5123:65535}[p.componentType]:1;for(let J=0;J<p.count;J++)for(let O=0;O<A;O++)W[J*A+O]=I[G](T+J*B+O*b.BYTES_PER_ELEMENT,!0)/Y;return{values:W,count:p.count,width:A}},u=(v,p)=>{if((v.mode??4)!==4)return;let w=h(v.attributes.POSITION),b=v.attributes.NORMAL===void 0?null:h(v.attributes.NORMAL),A=v.attributes.TEXCOORD_0===void 0?null:h(v.attributes.TEXCOORD_0),T=o.positions.length/3,B=to(p);for(let I=0;I<w.count;I++){let[G,Y,J]=w.values.subarray(3*I,3*I+3);for(let O=0;O<3;O++)o.positions.push(p[O]*G+p[4+O]*Y+p[8+O]*J+p[12+O]);if(b){let O=b.values.subarray(3*I,3*I+3),D=[0,1,2].map(V=>B[V][0]*O[0]+B[V][1]*O[1]+B[V][2]*O[2]),Z=Math.hypot(...D)||1;o.normals.push(...D.map(V=>V/Z))}else c=!1,o.normals.push(0,0,0);A?o.uvs.push(A.values[2*I],A.values[2*I+1]):(l=!1,o.uvs.push(0,0))}let W=v.indices===void 0?{values:Float64Array.from({length:w.count},(I,G)=>G),count:w.count}:h(v.indices);if((o.faces.length+W.count)/3>t)throw new Error(`It has more than ${t.toLocaleString("en")} triangles, which is what the page takes.`);for(let I of W.values){if(I>=w.count)throw new Error("A triangle names a point that does not exist.");o.faces.push(T+I)}},d=(v,p,w)=>{let b=i.nodes?.[v];if(!b||w>64)throw new Error("Its nodes are damaged.");let A=Xs(p,b.matrix??Qs(b));if(b.mesh!==void 0)for(let T of i.meshes[b.mesh].primitives)u(T,A);for(let T of b.children??[])d(T,A,w+1)},g=[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],k=i.scenes?.[i.scene??0];for(let v of k?.nodes??[])d(v,g,0);if(!o.faces.length)throw new Error("It has no triangles.");return{positions:Float32Array.from(o.positions),faces:Uint32Array.from(o.faces),normals:c?Float32Array.from(o.normals):null,uvs:l?Float32Array.from(o.uvs):null}}function Qs({translation:n=[0,0,0],rotation:[t,e,i,r]=[0,0,0,1],scale:s=[1,1,1]}){return[(1-2*(e*e+i*i))*s[0],2*(t*e+i*r)*s[0],2*(t*i-e*r)*s[0],0,2*(t*e-i*r)*s[1],(1-2*(t*t+i*i))*s[1],2*(e*i+t*r)*s[1],0,2*(t*i+e*r)*s[2],2*(e*i-t*r)*s[2],(1-2*(t*t+e*e))*s[2],0,...n,1]}function Xs(n,t){return Array.from({length:16},(e,i)=>[0,1,2,3].reduce((r,s)=>r+n[4*s+i%4]*t[4*Math.floor(i/4)+s],0))}function to(n){let t=(i,r)=>n[4*r+i],e=(i,r)=>{let[s,o]=[(i+1)%3,(i+2)%3],[c,l]=[(r+1)%3,(r+2)%3];return t(s,c)*t(o,l)-t(s,l)*t(o,c)};return[0,1,2].map(i=>[0,1,2].map(r=>e(i,r)))}var er=5e5,An=1<<25,ko=2048,nr=1<<28,Mo=65504,Ao=n=>n.name.slice(n.name.lastIndexOf(".")).toLowerCase(),Xe=n=>n.toLocaleString("en");async function sr(n){if(n.size>nr)throw new Error(`It has ${Xe(Math.round(n.size/2**20))} MB; the page takes ${nr/2**20}.`);let t=Ao(n);if(t===".hdr")return ir(Ri(await n.arrayBuffer(),An));if(t===".exr")return ir(await _o(await n.arrayBuffer()));if(t===".obj")return rr(Di(await n.text(),er));if(t===".glb")return rr(Hi(await n.arrayBuffer(),er));throw new Error("The page takes .hdr and .exr pictures of light, and .obj and .glb meshes.")}async function _o(n){let{default:t}=await Promise.resolve().then(()=>(tr(),Xi)),e=new DataView(n);if(n.byteLength<8||e.getUint32(0,!0)!==20000630)throw new Error("It does not begin as an OpenEXR file does.");let i;try{i=t(n,1015)}catch(h){throw new Error(`This EXR cannot be read: ${String(h.message??h).replace(/\.$/,"")}.`)}let{width:r,height:s,data:o}=i,c=o.length/(r*s);if(r*s>An)throw new Error(`It has ${Xe(r*s)} pixels; the page takes ${Xe(An)}.`);let l=new Float32Array(4*r*s);for(let h=0;h<s;h++)for(let u=0;u<r;u++){let d=((s-1-h)*r+u)*c,g=4*(h*r+u);for(let k=0;k<3;k++)l[g+k]=o[d+(c>=3?k:0)]}return{width:r,height:s,pixels:l}}function ir({width:n,height:t,pixels:e}){if(n<2||t<2)throw new Error("It has fewer than 2 × 2 pixels.");let i=0;for(let s=0;s<e.length;s++)if(s%4!==3){if(Number.isNaN(e[s]))throw new Error("It has NaN pixels; repair it in an image editor.");e[s]=Math.min(Math.max(e[s],0),e[s]===1/0?Mo:34e37),i=Math.max(i,e[s])}if(!(i>0))throw new Error("There is no light in it.");let r={width:n,height:t,pixels:e};for(;r.width>ko;)So(r);return{picture:r,note:r.width<n?`${n} × ${t}, averaged to ${r.width} × ${r.height}.`:`${n} × ${t}.`}}function So(n){let t=n.width>>1,e=Math.max(1,n.height>>1),i=new Float32Array(4*t*e),r=n.pixels;for(let s=0;s<e;s++)for(let o=0;o<t;o++)for(let c=0;c<3;c++){let l=(h,u)=>r[4*(Math.min(n.height-1,2*s+u)*n.width+2*o+h)+c];i[4*(s*t+o)+c]=(l(0,0)+l(1,0)+l(0,1)+l(1,1))/4}Object.assign(n,{width:t,height:e,pixels:i})}var zo=0;function rr({positions:n,normals:t,uvs:e,faces:i}){if(!i.length)throw new Error("It has no triangles.");let r=[1/0,1/0,1/0],s=[-1/0,-1/0,-1/0];for(let u of i)for(let d=0;d<3;d++){let g=n[3*u+d];if(!Number.isFinite(g))throw new Error("It has positions that are no numbers.");r[d]=Math.min(r[d],g),s[d]=Math.max(s[d],g)}let o=Math.max(...s.map((u,d)=>u-r[d]));if(!(o>0))throw new Error("All its points are one.");let c=2/o,l=[(r[0]+s[0])/2,r[1],(r[2]+s[2])/2],h=Float32Array.from(n,(u,d)=>(u-l[d%3])*c);return{id:++zo,height:(s[1]-r[1])*c,note:`${Xe(i.length/3)} triangles.`,mesh:{kind:0,positions:h,faces:i,uvs:e,growth:null,normals:t??Uo(h,i)}}}function Uo(n,t){let e=new Map,i=o=>`${n[3*o]},${n[3*o+1]},${n[3*o+2]}`,r=[];for(let o=0;o<n.length/3;o++)r.push(i(o));for(let o=0;o<t.length;o+=3){let c=[0,1,2].map(d=>[0,1,2].map(g=>n[3*t[o+d]+g])),l=c[1].map((d,g)=>d-c[0][g]),h=c[2].map((d,g)=>d-c[0][g]),u=[l[1]*h[2]-l[2]*h[1],l[2]*h[0]-l[0]*h[2],l[0]*h[1]-l[1]*h[0]];for(let d=0;d<3;d++){let g=r[t[o+d]],k=e.get(g)??[0,0,0];e.set(g,k.map((v,p)=>v+u[p]))}}let s=new Float32Array(n.length);return r.forEach((o,c)=>{let l=e.get(o)??[0,1,0],h=Math.hypot(...l);s.set(h>0?l.map(u=>u/h):[0,1,0],3*c)}),s}var To={reset:"M3.5 8a4.5 4.5 0 1 0 1.6-3.4M3.5 2.5v3h3",undo:"M3 6h6.5a3.5 3.5 0 0 1 0 7H6M3 6l3-3M3 6l3 3",redo:"M13 6H6.5a3.5 3.5 0 0 0 0 7H10M13 6l-3-3M13 6l-3 3",swap:"M3 5h10l-2.5-2.5M13 11H3l2.5 2.5",light:"M8 5a3 3 0 1 0 0 6 3 3 0 0 0 0-6zM8 1v1.5M8 13.5V15M1 8h1.5M13.5 8H15M3 3l1 1M12 12l1 1M13 3l-1 1M4 12l-1 1",large:"M9.5 2.5h4v4M6.5 13.5h-4v-4M13.5 2.5L9 7M2.5 13.5L7 9",eye:"M1.5 8s2.4-4.5 6.5-4.5S14.5 8 14.5 8 12.1 12.5 8 12.5 1.5 8 1.5 8zM8 6.2a1.8 1.8 0 1 0 0 3.6 1.8 1.8 0 0 0 0-3.6z",closed:"M1.5 6.5S4 10.5 8 10.5s6.5-4 6.5-4M3.6 9.2L2.3 11M12.4 9.2l1.3 1.8M8 10.5v2.2",warn:"M8 2.2L14.5 13.5h-13zM8 6.5v3.2M8 11.6v.01",info:"M8 2a6 6 0 1 0 0 12A6 6 0 0 0 8 2zM8 7.3v3.4M8 5.2v.01",layers:"M8 2l6 3.2-6 3.2-6-3.2zM2 8.2l6 3.2 6-3.2M2 11l6 3.2 6-3.2",plots:"M2 2v12h12M4.5 10.5l3-4 2.5 2 3.5-5",code:"M5.5 4L1.5 8l4 4M10.5 4l4 4-4 4",wipe:"M5.5 4.5L2 8l3.5 3.5M10.5 4.5L14 8l-3.5 3.5",close:"M4 4l8 8M12 4l-8 8",plus:"M8 3v10M3 8h10"},ct=n=>ot`<svg class="ic" viewBox="0 0 16 16" aria-hidden="true"><path d=${To[n]}></path></svg>`;var or=180/Math.PI;function Tt(n){if(n===0)return"0";let t=Math.abs(n);return t<.001||t>=1e5?n.toExponential(2).replace(/\.?0+e/,"e").replace("e+","e"):String(Number(n.toFixed(t<.1?4:t<10?3:t<100?2:1)))}var lt=(n,t=4)=>Number.isFinite(n)?n.toFixed(t).replace("-","−"):"–",le=(n,t)=>n.kind==="angle"?t*or:t,Eo=(n,t)=>n.kind==="angle"?t/or:t,Te=n=>n.kind==="angle"?"°":"";function tn(n,t){let e=n.scale==="log"?Math.log(Math.max(t,n.soft_low)/n.soft_low)/Math.log(n.soft_high/n.soft_low):(t-n.soft_low)/(n.soft_high-n.soft_low);return Math.max(0,Math.min(1,e))}function en(n,t){if(t<=0)return n.scale==="log"?n.low:n.soft_low;if(t>=1)return n.soft_high;let e=n.scale==="log"?n.soft_low*(n.soft_high/n.soft_low)**t:n.soft_low+t*(n.soft_high-n.soft_low);return Number(e.toPrecision(4))}function _n(n){let t=e=>Tt(le(n,e))+Te(n);return n.high===null?`at least ${t(n.low)}`:`${t(n.low)} to ${t(n.high)}`}function ar(n,t){let e=Number(t.replace("−","-").replace(",",".").replace("°","").trim());if(t.trim()===""||!Number.isFinite(e))return{error:`${t.trim()||"Nothing"} is no number.`};let i=Eo(n,e),r=1e-7*Math.max(1,Math.abs(i));return i<n.low-r||n.high!==null&&i>n.high+r?{error:`Allowed is ${_n(n)}.`}:{value:Math.max(n.low,n.high===null?i:Math.min(n.high,i))}}function lr(n){let t=[];for(let e=Math.ceil(Math.log10(n.soft_low)-1e-9);e<=Math.log10(n.soft_high)+1e-9;e++){let i=[...String(e)].map(r=>r==="-"?"⁻":"⁰¹²³⁴⁵⁶⁷⁸⁹"[r]).join("");t.push({at:tn(n,10**e),text:e<-2||e>3?`10${i}`:String(Number((10**e).toFixed(3))).replace(/^0\./,".")})}return t}var ce=n=>n<=.0031308?12.92*Math.max(n,0):1.055*Math.min(n,1)**.4166666666666667-.055,cr=n=>n<=.04045?n/12.92:((n+.055)/1.055)**2.4,Yt=n=>`rgb(${n.map(t=>Math.round(255*ce(t))).join(" ")})`,Ee=n=>`#${n.map(t=>Math.round(255*ce(t)).toString(16).padStart(2,"0")).join("").toUpperCase()}`;function hr(n){let t=/^#?([0-9a-f]{6}|[0-9a-f]{3})$/i.exec(n.trim());if(!t)return null;let e=t[1].length===3?[...t[1]].map(i=>i+i).join(""):t[1];return[0,2,4].map(i=>cr(parseInt(e.slice(i,i+2),16)/255))}function fr(n){let[t,e,i]=n.map(ce),r=Math.max(t,e,i),s=r-Math.min(t,e,i);return[(s===0?0:r===t?((e-i)/s+6)%6:r===e?(i-t)/s+2:(t-e)/s+4)*60,r===0?0:s/r,r]}function Sn([n,t,e]){let i=r=>{let s=(r+n/60)%6;return e-e*t*Math.max(0,Math.min(s,4-s,1))};return[i(5),i(3),i(1)].map(cr)}var gt=Math.PI/180,zn=["red","green","blue","luminance"],Ie=(n,t)=>t===3?.2126*n[0]+.7152*n[1]+.0722*n[2]:n[t],he=n=>n.map(([t,e],i)=>`${i?"L":"M"}${t.toFixed(1)} ${e.toFixed(1)}`).join(""),Un=(n,t)=>ot`<path d=${n} fill="none" stroke=${t==="A"?"var(--a)":"var(--b)"} stroke-width="1.75" stroke-linejoin="round" stroke-dasharray=${t==="A"?"none":"5 3"}></path>`,pr=n=>n>=-2&&n<=3?String(Number((10**n).toFixed(3))):`10${[...String(n)].map(t=>t==="-"?"⁻":"⁰¹²³⁴⁵⁶⁷⁸⁹"[t]).join("")}`;function fe(n,t,e,i){let{width:r=300,height:s=150}=n.sizes[t]??{};return $`<svg class="p" data-chart=${t} viewBox=${`0 0 ${r} ${s}`} role="img" aria-label=${e}>${i(r,s)}</svg>`}function Tn(n,t,e,i){let r=Math.min(e/2-34,i-30),s=e/2,o=i-20,c=n.flatMap(({slice:A})=>A.map(T=>Ie(T.f,t)*Math.cos(T.angle*gt))).filter(A=>A>0&&Number.isFinite(A)),l=Math.ceil(Math.log10(Math.max(1e-6,...c))+1e-9),h=Math.min(4,Math.max(3,l+2)),u=l-h,d=A=>A>0?Math.max(0,(Math.log10(A)-u)/h)*r:0,g=(A,T)=>[s+T*Math.sin(A*gt),o-T*Math.cos(A*gt)],k=Array.from({length:h},(A,T)=>T+1).map(A=>{let T=A/h*r;return ot`<path d=${`M${s-T} ${o}A${T} ${T} 0 0 1 ${s+T} ${o}`} fill="none" stroke="var(--line)"></path>${r/h>22||A%2===h%2?ot`<text x=${s+T} y=${o+14} text-anchor="middle">${pr(u+A)}</text>`:""}`}),v=[-60,-30,0,30,60].map(A=>ot`<path d=${he([[s,o],g(A,r)])} stroke="var(--line)"></path>${A?ot`<text x=${g(A,r+14)[0]} y=${g(A,r+14)[1]+4} text-anchor="middle">${A<0?"−":""}${Math.abs(A)}°</text>`:""}`),p=n[0]?.thetaO??45,[w,b]=g(-p,r);return ot`${k}${v}<path d=${`M${s-r} ${o}H${s+r}`} stroke="var(--edge)"></path>
        ${n.map(({letter:A,slice:T})=>Un(he(T.map(B=>g(B.angle,d(Ie(B.f,t)*Math.cos(B.angle*gt))))),A))}
        <path d=${he([[s,o],[w,b]])} stroke="var(--text)" stroke-width="1.25" stroke-dasharray="2 3"></path><text x=${w+16} y=${b+4} class="strong">ωo</text>`}function dr({x0:n,x1:t,y0:e,y1:i,top:r,bottom:s,ticks:o,log:c=!1,xs:l=[0,30,60,90]},h,u){return ot`${o.map(d=>ot`<path d=${`M${n} ${u(d)}H${t}`} stroke=${d===1&&!c?"var(--edge)":"var(--line)"}></path><text x=${n-8} y=${u(d)+4} text-anchor="end">${c?pr(Math.round(Math.log10(d))):Number(d.toFixed(3))}</text>`)}
        ${l.map(d=>ot`<text x=${h(d)} y=${i+16} text-anchor="middle">${d<0?"−":""}${Math.abs(d)}°</text>`)}`}function En(n,t,e,i,r){let[s,o,c,l]=[34,e-62,8,i-22],h=Math.max(1,...n.flatMap(b=>b.albedo.map(A=>Ie(A.value,t))).filter(Number.isFinite)),u=h<=1.02?1.1:Math.ceil(h*2+.1)/2,d=u>4?Math.ceil(u/4):u>1.6?1:.5,g=b=>s+(o-s)*b/90,k=b=>l-(l-c)*Math.min(b,u)/u,v=Array.from({length:Math.floor(u/d+1e-6)+1},(b,A)=>A*d),p=[],w=n.map(({letter:b,albedo:A})=>{let T=A.map(G=>[G.angle,Ie(G.value,t)]),B=T.filter(([,G])=>G>1.0005),W=T[T.length-1][1],I=k(W)+4;for(let G of p)Math.abs(G-I)<14&&(I=G+(I>=G?14:-14));return p.push(I),ot`${B.length?ot`<path fill="var(--warn)" opacity=".28" d=${`${he([[g(B[0][0]),k(1)],...B.map(([G,Y])=>[g(G),k(Y)]),[g(B[B.length-1][0]),k(1)]])}Z`}></path>
            <text x=${Math.min(g(B[0][0])-6,o-4)} y=${Math.max(k(1)-12,c+10)} text-anchor=${g(B[0][0])>s+150?"end":"start"} class="warn">${b} gains energy ${B[0][0]>0?`from ${Math.round(B[0][0])}°`:"everywhere"}</text>`:""}
            ${Un(he(T.map(([G,Y])=>[g(G),k(Y)])),b)}<text x=${o+8} y=${I} class=${`of${b}`}>${b} ${lt(W,2)}</text>`});return ot`${dr({x0:s,x1:o,y0:c,y1:l,ticks:v},g,k)}${w}
        ${r===null?"":ot`<path d=${`M${g(r)} ${c}V${l}`} stroke="var(--text)" stroke-dasharray="2 3"></path><text x=${g(r)+(r>55?-6:6)} text-anchor=${r>55?"end":"start"} y=${c+10} class="strong">θo ${Math.round(r)}°</text>`}`}function mr(n,t,e,i){let[r,s,o,c]=[44,e-24,12,i-26],l=p=>Ie(p.f,t)*Math.cos(p.angle*gt),h=n.flatMap(p=>p.slice.map(l)).filter(p=>p>0),u=Math.ceil(Math.log10(Math.max(1e-5,...h))+1e-9),d=Math.max(u-6,Math.floor(Math.log10(Math.max(1e-9,Math.min(...h,1))))),g=p=>r+(s-r)*(p+90)/180,k=p=>c-(c-o)*Math.max(0,Math.log10(Math.max(p,1e-12))-d)/(u-d),v=Array.from({length:u-d+1},(p,w)=>10**(d+w));return ot`${dr({x0:r,x1:s,y0:o,y1:c,ticks:v,log:!0,xs:[-90,-60,-30,0,30,60,90]},g,k)}${n.map(({letter:p,slice:w})=>Un(he(w.map(b=>[g(b.angle),k(l(b))])),p))}
        <path d=${`M${g(-(n[0]?.thetaO??0))} ${o}V${c}`} stroke="var(--text)" stroke-dasharray="2 3"></path><text x=${g(-(n[0]?.thetaO??0))+6} y=${o+12} class="strong">ωo</text>`}function gr(n,t){n.width=n.height=jt;let e=n.getContext("2d"),i=e.createImageData(jt,jt),r=t.filter(Boolean).map(o=>Math.max(...o)).filter(Number.isFinite).sort((o,c)=>o-c),s=Math.max(1e-9,r[Math.floor(.95*r.length)]??1);t.forEach((o,c)=>i.data.set(o?[...o.map(l=>Math.round(255*ce(Math.min(1,Math.max(0,l/s))))),255]:[0,0,0,0],4*c)),e.putImageData(i,0,0)}var ur=3e3;function vr(n,t,{az:e,el:i,log:r,weights:s},o){let c=n.width=n.clientWidth*o,l=n.height=n.clientHeight*o,h=n.getContext("2d");h.clearRect(0,0,c,l);let[u,d,g,k]=[Math.cos(e*gt),Math.sin(e*gt),Math.cos(i*gt),Math.sin(i*gt)],v=Math.min(c*.46,l*.72),p=c/2,w=l*.82,b=([O,D,Z])=>{let V=u*O+d*D,rt=u*D-d*O;return[V,g*Z+k*rt,g*-rt+k*Z]},A=O=>{let[D,Z]=b(O);return[p+v*D,w-v*Z]};h.lineWidth=o,h.strokeStyle="#ffffff30";for(let O of[.5,1]){h.beginPath();for(let D=0;D<=360;D+=4)h.lineTo(...A([O*Math.cos(D*gt),O*Math.sin(D*gt),0]));h.stroke()}let T=(O,D,Z)=>{h.strokeStyle=h.fillStyle=Z,h.beginPath(),h.moveTo(...A([0,0,0])),h.lineTo(...A(O.map(nt=>1.1*nt))),h.stroke(),h.font=`${12*o}px sans-serif`;let[V,rt]=A(O.map(nt=>1.17*nt));h.fillText(D,V-6*o,rt)},B=t.filter(Boolean),W=B.flatMap(O=>O.f.map((D,Z)=>Math.max(...D)*O.grid[Z][2])),I=Math.max(1e-9,...W),G=O=>r?Math.log1p(O/I*ur)/Math.log1p(ur):O/I,Y=[];B.forEach(O=>{let D=O.grid.map((Z,V)=>{let rt=.2126*O.f[V][0]+.7152*O.f[V][1]+.0722*O.f[V][2],nt=G(rt*Z[2]);return Z.map(X=>X*nt)});for(let Z=0;Z<O.rings;Z++)for(let V=0;V<O.segments;V++){let rt=[Z*O.segments+V,Z*O.segments+(V+1)%O.segments,(Z+1)*O.segments+(V+1)%O.segments,(Z+1)*O.segments+V],nt=rt.map(ft=>b(D[ft])),X=nt[2].map((ft,It)=>ft-nt[0][It]),vt=nt[3].map((ft,It)=>ft-nt[1][It]),Et=[X[1]*vt[2]-X[2]*vt[1],X[2]*vt[0]-X[0]*vt[2],X[0]*vt[1]-X[1]*vt[0]],wt=Math.hypot(...Et);if(wt<1e-12)continue;let kt=.3+.7*Math.abs((.3*Et[0]+.6*Et[1]+.74*Et[2])/wt),Dt=O.f[rt[0]],xt=Math.max(...Dt,1e-9);Y.push({z:nt[0][2]+nt[1][2]+nt[2][2]+nt[3][2],p:nt,letter:O.letter,colour:Dt.map(ft=>Math.round(255*ce(ft/xt*.8*kt)))})}}),Y.sort((O,D)=>O.z-D.z);for(let{p:O,colour:D,letter:Z}of Y){h.beginPath();for(let[V,rt]of O)h.lineTo(p+v*V,w-v*rt);h.closePath(),Z==="B"&&B.length>1?(h.strokeStyle="#ffae5766",h.stroke()):(h.fillStyle=h.strokeStyle=`rgb(${D.join(" ")})`,h.fill(),h.stroke())}let J=B[0]?.thetaO??45;if(T([-Math.sin(J*gt),0,Math.cos(J*gt)],"ωo","#f1f1f3"),T([0,0,1],"n","#b6b6bd"),s)for(let O of B[0]?.points??[]){let D=Math.max(...O.weight),Z=.2126*O.f[0]+.7152*O.f[1]+.0722*O.f[2],[V,rt]=A(O.wi.map(nt=>nt*(G(Z*O.wi[2])+.03)));h.fillStyle=xr(D),h.beginPath(),h.arc(V,rt,1.7*o,0,7),h.fill()}}function xr(n){let t=Math.max(-1,Math.min(1,Math.log2(Math.max(n,1e-6))/3));return t<0?`rgb(${Math.round(255*(1+.75*t))} ${Math.round(255*(1+.4*t))} 255)`:`rgb(255 ${Math.round(255*(1-.75*t))} ${Math.round(255*(1-.85*t))})`}function wr(n,t,e){let i=n.width=n.clientWidth*e,r=n.height=n.clientHeight*e,s=n.getContext("2d");s.clearRect(0,0,i,r),t.filter(Boolean).forEach((o,c,{length:l})=>{let h=Math.min(i/l/2.4,r/2.7),u=i*(c+.5)/l,d=r/2+8*e;s.strokeStyle="#ffffff40",s.lineWidth=e;for(let b of[30,60,90])s.beginPath(),s.arc(u,d,h*Math.sin(b*gt),0,7),s.stroke();for(let b of o.points)s.fillStyle=xr(Math.max(...b.weight)),s.beginPath(),s.arc(u+h*b.wi[0],d-h*b.wi[1],2.4*e,0,7),s.fill();let g=o.points.map(b=>Math.max(...b.weight)),k=g.reduce((b,A)=>b+A,0)/(g.length+o.wasted||1),v=g.reduce((b,A)=>b+(A-k)**2,o.wasted*k*k)/(g.length+o.wasted||1);s.fillStyle="#f1f1f3",s.font=`${12*e}px sans-serif`,s.textAlign="center",s.fillText(`${l>1?`${o.letter}: `:""}weight ${lt(k,3)}, deviation ${lt(Math.sqrt(v),3)}, at most ${lt(Math.max(0,...g),2)}, ${o.wasted} of ${o.points.length+o.wasted} wasted`,u,d+h+22*e),s.strokeStyle="#f1f1f3";let[p,w]=[u-h*Math.sin(o.thetaO*gt),d];s.beginPath(),s.arc(p,w,4*e,0,7),s.stroke(),s.fillText("ωo",p,w-8*e)})}function Vt(n){let t=[{prefix:"",model:n.payload.model,child:null}];for(let[e,i]of n.models)t[t.length-1].child=e,t.push({prefix:`${e}.`,model:i,child:null});return t.forEach((e,i)=>{e.number=i+1,e.title=Co(n,e,t.length)}),t}function Co(n,t,e){let i=n.values.get(`${t.prefix}sigma_a`),r=n.values.get(`${t.prefix}thickness`);return t.child?i?.some(s=>s>0)&&r?.[0]!==0?"Tinted coat":"Clear coat":e>1?"Base":"Surface"}var Oo=["eta","top_eta","alpha","roughness","sigma","shininess","metal_alpha","metallic"];function Po(n,t){let e=t.child?[]:[t.model];for(let i of Oo){let r=n.values.get(t.prefix+i);r?.length===1&&e.length<3&&e.push(`${i} ${Tt(r[0])}`)}return e.join(" · ")}function yr(n,{prefix:t,child:e}){let i=h=>n.values.get(t+h),r=i("sigma_a"),s=i("thickness")?.[0]??1;if(e){let h=r?r.map(u=>Math.exp(-2*u*s)):[1,1,1];return h.every(u=>u>.98)?"var(--cut1)":Yt(h)}let o=i("rho")??i("base_color");if(o)return Yt(o.map(h=>Math.max(h,.02)));let c=i("metal_eta")??i("eta"),l=i("metal_k")??i("k");return c?.length===3&&l?.length===3?Yt(c.map((h,u)=>((h-1)**2+l[u]**2)/((h+1)**2+l[u]**2))):i("f0")?Yt(i("f0")):"var(--edge)"}var br=n=>{let t=n;return()=>(t=t*16807%2147483647)/2147483647};function No(n,t){let e=br(t*7919+17);return Array.from({length:19},(i,r)=>`${r?"L":"M"}${4*r} ${(9+n*9*(e()-.5)).toFixed(1)}`).join("")}function Lo(n,t){for(let e of["alpha","roughness","sigma","metal_alpha"]){let i=n.values.get(t+e);if(i)return Math.min(1,i[0])**.6}return .35}function Fo(n,t,e){let i=No(Lo(n,t.prefix),t.number),r=br(99),s=t.child?[]:Array.from({length:26},()=>ot`<circle cx=${(4+64*r()).toFixed(1)} cy=${(18+28*r()).toFixed(1)} r=${(.6+.7*r()).toFixed(1)} fill="#0003"></circle>`);return $`<svg viewBox="0 0 72 50" preserveAspectRatio="none" aria-hidden="true">${ot`
        <path d="M0 0H72V50H0Z" fill=${e}></path><path d=${`${i}L72 50L0 50Z`} fill=${yr(n,t)}></path>${s}
        <path d=${i} fill="none" stroke="#fff9" stroke-width="1.25"></path>`}</svg>`}function $r(n){let t=n.edited(),e=Vt(t),i="var(--air)",r=e.map((s,o)=>{let c=o===n.layerIndex(),l=t.hidden.has(s.prefix),h=Fo(t,s,i);return i=yr(t,s),$`<div class="lay ${l?"off":""} ${e.length>5&&!c?"thin":""}" ?data-on=${c}>${h}
            <button role="tab" aria-selected=${c} @click=${()=>n.set({layer:o})}><b>${s.number}&ensp;${s.title}</b><small>${Po(t,s)}</small></button>
            ${s.child?$`<button class="ib" aria-pressed=${l} aria-label=${`${l?"Show":"Hide"} layer ${s.number}`} title=${l?"Show":"Hide: see what is below"} @click=${()=>n.hide(s.prefix)}>${ct(l?"closed":"eye")}</button>
            <button class="ib" aria-label=${`Remove layer ${s.number}`} title="Remove this coat" @click=${()=>n.removeLayer(s)}>${ct("close")}</button>`:$`<span></span><span></span>`}</div>`});return $`<div class="sec"><div class="hd"><h2>Layers</h2>${n.two?$`<span class="xs dim">edit</span><div class="seg" role="group" aria-label="Edit">${["A","B","AB"].map(s=>$`
        <button aria-pressed=${n.state.edit===s} @click=${()=>n.set({edit:s})}>${s==="AB"?"A + B":s}</button>`)}</div>`:""}
        <span class="sp"></span><button class="btn" title="A clear coat above everything" @click=${()=>n.addCoat()}>+ Coat</button></div>
        <div class="stack" role="tablist" aria-label="Layers, top first" aria-orientation="vertical">${r}</div></div>`}var Bo={water:1.333,"soap film":1.4,acrylic:1.49,"clear coat":1.5,polycarbonate:1.585,sapphire:1.77,zirconia:2.16,diamond:2.417},Ro={mesh:"from the mesh",viewer:"from the viewer",flakes:"from a flake map",texture:"from a texture"},kr=(n,t)=>t.startsWith(n)&&!t.slice(n.length).includes("."),In=n=>n.slice(n.lastIndexOf(".")+1),Do=n=>n?`${n[0].toUpperCase()}${n.slice(1).replaceAll("="," = ")}.`:"";function Mr(n){let t=n.edited(),e=Vt(t),i=e[n.layerIndex()],r=t.payload.parameters.filter(l=>kr(i.prefix,l.path)),s=t.payload.options.filter(l=>kr(i.prefix,l.path)),o=new Map(t.payload.hooks.map(l=>[l.path,l])),c=l=>l.prefix?l.prefix.slice(0,-1):l.model;return $`<div role="tabpanel" aria-label=${`Layer ${i.number}`}>
        ${t.error?$`<div class="sec"><div class="note" role="alert">${ct("warn")}<div><b>${t.error.title}</b><p>${t.error.text}</p></div></div></div>`:""}
        <div class="sec"><div class="hd"><h2>${e.length>1?$`${i.number}&ensp;`:""}${i.title}</h2><span class="sp"></span>
            <div class="pick">${Ho(n,t,i)}</div>
            <button class="ib" aria-label="Reset layer" title="Reset layer" @click=${()=>n.resetLayer(i)}>${ct("reset")}</button></div>
            ${e.length>1?$`<div class="path">${e.map((l,h)=>$`${h?" › ":""}${l===i?$`<b>${c(l)}</b>`:c(l)}`)}</div>`:""}
            ${i.prefix?"":$`<p class="hint about1">${t.payload.description}</p>`}
            ${r.map(l=>qo(n,t,i,l,o.get(l.path)))}</div>
        ${s.length?$`<div class="sec"><div class="hd"><h2>Options</h2><span class="dim xs">${t.busy||"recompile in under 0.5 s"}</span><span class="sp"></span>
            ${s.some(l=>n.differs(l.path))?$`<span class="xs dim"><i class="diffdot"></i>&ensp;differs in ${t.letter==="A"?"B":"A"}</span>`:""}</div>
            ${s.map(l=>Jo(n,t,l))}</div>`:""}</div>`}function Ho(n,t,e){let i=n.start.catalogue.filter(o=>o.kind==="model"||!e.prefix),r=e.prefix?e.model:t.payload.name,s=(o,c)=>$`<optgroup label=${c}>${i.filter(l=>l.kind===o).map(l=>$`<option value=${l.name} ?selected=${l.name===r}>${l.name}</option>`)}</optgroup>`;return $`<select aria-label="Model of this layer" .value=${r} @change=${o=>n.chooseModel(e,o.target.value)}>
        ${i.some(o=>o.kind==="file")?s("file","Your files"):""}${s("model","Models")}${e.prefix?"":s("material","Materials")}</select>`}function Go(n,t,e){return n.used?e?Ro[e.source]:n.kind==="index"&&n.width===1&&n.path.includes(".")?`over layer ${t.number-1}`:n.kind==="slope"&&n.scale==="log"?"log scale":["factor","number","length"].includes(n.kind)?"":n.kind:"unused"}function qo(n,t,e,i,r){let s=In(i.path),o=t.values.get(i.path),c=!i.used||!!r,l=Go(i,e,r),h=t.changed(i.path)&&!c?$`<button class="rs" aria-label=${`Reset ${i.path}`} title="Reset" @click=${()=>n.resetParameter(i.path)}>${ct("reset")}</button>`:$`<span></span>`,u=$`<label title=${`${i.doc}; ${_n(i)}`} @dblclick=${()=>n.resetParameter(i.path)}>${s}${l?$`<small>${l}</small>`:""}</label>`,d=(p,w="hint")=>$`<span></span><div class="wide ${w}">${p}</div><span></span>`,g=n.fieldError?.path===i.path?$`<span></span><div class="wide err" role="alert">${n.fieldError.text} The picture still shows ${o.map(p=>`${Tt(le(i,p))}${Te(i)}`).join(", ")}.</div><span></span>`:"",k=i.used?"":d(Do(i.unused_because));if(i.width===1){let p=o[0],w=t.values.get(`${e.prefix}sigma_a`),b=s==="thickness"&&w?.some(A=>A>0);return $`<div class="prm ${c?"offp":""}" title=${i.doc}>${u}${Zo(n,i,p,c,b?Wo(w,i):"")}${Cn(n,i,p,c,0)}${h}
            ${g}${i.scale==="log"&&!b&&!c?$`<span></span><div class="tick">${lr(i).map(A=>$`<span .style=${`left:${100*A.at}%`}>${A.text}</span>`)}</div><span></span><span></span>`:""}
            ${i.kind==="index"&&!c?d(Yo(n,t,e,i,p),""):""}${i.kind==="angle"&&!c?d(`${Tt(p)} rad in code and links.`):""}
            ${b?d("Track: white light after down and up, seen from above."):""}${k}</div>`}if(i.kind==="reflectance"&&!c)return Ko(n,i,o,u,h,g);let v=!c&&i.kind==="index"&&t.parameter(i.path.replace(/eta$/,"k"));return $`<div class="prm ${c?"offp":""}" title=${i.doc}>${u}${v?$`<div class="wide">${Vo(n,t,i)}</div>${h}<span></span>`:""}
        <div class="tri wide">${[0,1,2].map(p=>$`<span data-c=${"RGB"[p]}>${Cn(n,i,o[p],c,p)}</span>`)}</div>${v?$`<span></span>`:h}${g}${k}</div>`}function Zo(n,t,e,i,r){let s=tn(t,e),o=l=>n.setParameter(t.path,[l]),c=l=>{let h={ArrowRight:1,ArrowUp:1,ArrowLeft:-1,ArrowDown:-1}[l.key];if(!h)return;l.preventDefault();let u=tn(t,n.edited().values.get(t.path)[0]);o(en(t,Math.min(1,Math.max(0,u+h*(l.shiftKey?.1:.01)))))};return $`<input type="range" class=${r?"beer":""} aria-label=${t.path} aria-valuetext=${`${Tt(le(t,e))}${Te(t)}`} min="0" max="1000" step="1" ?disabled=${i}
        .value=${String(Math.round(1e3*s))} .style=${`--f:${100*s}%;${r?`--g:${r}`:""}`} @input=${l=>o(en(t,l.target.valueAsNumber/1e3))} @keydown=${c}>`}function Wo(n,t){return`linear-gradient(90deg,${Array.from({length:9},(i,r)=>Yt(n.map(s=>Math.exp(-2*s*en(t,r/8))))).join(",")})`}function Cn(n,t,e,i,r){let s=t.width===1?`${t.path}, value`:`${t.path} ${"RGB"[r]}`,o=`${Tt(le(t,e))}${Te(t)}`,c=n.fieldError?.path===t.path&&n.fieldError.channel===r?n.fieldError:null,l=u=>{if(u.target.value===o)return;let d=ar(t,u.target.value);if(d.error){n.fail({path:t.path,channel:r,text:d.error,typed:u.target.value});return}let g=n.edited().values.get(t.path).slice();g[r]=d.value,n.setParameter(t.path,g)},h=u=>{u.stopPropagation(),u.key==="Enter"&&l(u),u.key==="Escape"&&(u.target.value=o,n.fail(null),u.target.blur())};return $`<input class="n ${c?"bad":""}" inputmode="decimal" spellcheck="false" autocomplete="off" aria-label=${s} aria-invalid=${c?"true":"false"} ?disabled=${i}
        .value=${c?c.typed:o} title=${String(le(t,e))} @change=${l} @focus=${u=>u.target.select()} @keydown=${h}>`}var jo=(n,t)=>Vt(n).slice(0,t.number-1).reduce((e,i)=>e*(n.values.get(`${i.prefix}eta`)?.[0]??1),1);function Yo(n,t,e,i,r){let s=i.path.includes(".")?jo(t,e):1,o=Object.entries(Bo).map(([l,h])=>[l,h/s]).filter(([,l])=>l>=i.low&&(i.high===null||l<=i.high)),c=o.find(([,l])=>Math.abs(l-r)<5e-4)?.[0]??"";return $`<select aria-label=${`Named index of ${i.path}`} .value=${c} @change=${l=>l.target.value&&n.setParameter(i.path,[o.find(([h])=>h===l.target.value)[1]])}>
        <option value="" ?selected=${!c}>custom${s!==1?`: ${Tt(r)} over layer ${e.number-1} (${Tt(r*s)} in air)`:`, ${lt(r,3)}`}</option>
        ${o.map(([l,h])=>$`<option value=${l} ?selected=${l===c}>${l}, ${lt(h*s,3)}${s!==1?` (${lt(h,3)} here)`:""}</option>`)}</select>`}function Vo(n,t,e){let i=e.path.replace(/eta$/,"k"),r=t.parameter(i),s=t.values.get(e.path),o=t.values.get(i),c=(d,g)=>g.every(k=>k>=d.low&&k<=(d.high??1/0)),l=(d,g)=>d.every((k,v)=>Math.abs(k-g[v])<1e-4),h=Object.entries(n.start.metals).filter(([,d])=>c(e,d.eta)&&c(r,d.k)),u=h.find(([,d])=>l(d.eta,s)&&l(d.k,o))?.[0]??"";return $`<select aria-label=${`Named metal of ${e.path}`} .value=${u} @change=${d=>{let g=n.start.metals[d.target.value];g&&n.setParameters({[e.path]:g.eta,[i]:g.k})}}>
        <option value="" ?selected=${!u}>custom</option>${h.map(([d,g])=>$`<option value=${d} ?selected=${d===u}>${d}, ${g.eta.map(Tt).join(" ")}</option>`)}</select>`}var Ce=n=>Math.min(1,Math.max(0,n));function Ko(n,t,e,i,r,s){let o=n.hue?.path===t.path&&Ee(Sn(n.hue.hsv))===Ee(e),[c,l,h]=o?n.hue.hsv:fr(e),u=n.openColours.has(t.path),d=p=>{n.hue={path:t.path,hsv:p},n.setParameter(t.path,Sn(p).map(w=>Number(Ce(w).toPrecision(5))))},g=(p,w)=>{let b=p.currentTarget,A=b.getBoundingClientRect(),T=B=>w(Ce((B.clientX-A.left)/A.width),Ce((B.clientY-A.top)/A.height));b.setPointerCapture(p.pointerId),b.onpointermove=T,b.onpointerup=()=>{b.onpointermove=null},T(p)},k=(p,w)=>{let b={ArrowRight:[1,0],ArrowLeft:[-1,0],ArrowUp:[0,1],ArrowDown:[0,-1]}[p.key];b&&(p.preventDefault(),w(b[0]*(p.shiftKey?.1:.01),b[1]*(p.shiftKey?.1:.01)))},v=p=>{let w=hr(p.target.value);w?n.setParameter(t.path,w):n.fail({path:t.path,channel:-1,text:`${p.target.value} is no colour such as #EFCEAD.`})};return $`<div class="prm" title=${t.doc}>${i}<div class="wide row">
            <button class="swt" .style=${`background:${Yt(e)}`} aria-expanded=${u} aria-label=${`${u?"Close":"Open"} the colours of ${t.path}`} title="Colours" @click=${()=>n.toggleColour(t.path)}></button>
            <input class="n m left" aria-label=${`${t.path}, sRGB`} spellcheck="false" .value=${Ee(e)} @change=${v} @keydown=${p=>{p.stopPropagation(),p.key==="Enter"&&v(p)}}></div>${r}
        ${u?$`<span></span><div class="wide"><div class="sv" role="slider" tabindex="0" aria-label=${`Saturation and value of ${t.path}`} aria-valuetext=${Ee(e)} .style=${`--h:${c}`} @pointerdown=${p=>g(p,(w,b)=>d([c,w,1-b]))} @keydown=${p=>k(p,(w,b)=>d([c,Ce(l+w),Ce(h+b)]))}><i .style=${`left:${100*l}%;top:${100*(1-h)}%`}></i></div>
            <div class="hue" role="slider" tabindex="0" aria-label=${`Hue of ${t.path}`} aria-valuenow=${Math.round(c)} @pointerdown=${p=>g(p,w=>d([360*Math.min(w,.9999),l,h]))} @keydown=${p=>k(p,w=>d([(c+300*w+360)%360,l,h]))}><i .style=${`left:${c/3.6}%`}></i></div></div><span></span>`:""}
        <label class="c"><small>linear</small></label><div class="tri wide">${[0,1,2].map(p=>$`<span data-c=${"RGB"[p]}>${Cn(n,t,e[p],!1,p)}</span>`)}</div><span></span>${s}</div>`}function Jo(n,t,e){let i=In(e.path),r=t.options.get(e.path),s=t.startOf(e.path,e.default),o=e.values.filter(u=>!u.allowed),c=n.refused?.path===e.path?n.refused:null,l=u=>{let d=e.values.find(g=>g.value===u.target.value);if(d.allowed){n.setOptions({[e.path]:d.value});return}u.target.value=r,n.refuse(e.path,d)},h=Object.entries(c?.remedy??{});return $`<div class="opt" title=${e.doc}><span class=${r!==s?"ch":""}>${i}${n.differs(e.path)?$`<i class="diffdot" role="img" aria-label="differs"></i>`:""}</span>
        <select aria-label=${e.path} .value=${r} @change=${l}>${e.values.map(u=>$`<option value=${u.value} ?selected=${u.value===r}>${u.value}${u.allowed?"":" – refused"}</option>`)}</select>
        ${r!==s?$`<button class="rs" aria-label=${`Reset ${e.path}`} title="Reset" @click=${()=>n.setOptions({[e.path]:s})}>${ct("reset")}</button>`:$`<span></span>`}
        ${c?$`<div class="why" role="alert"><p><b>${c.value}</b>: ${c.reason}</p><div class="row">
            ${h.length?$`<button class="btn" @click=${()=>n.setOptions({...c.remedy,[e.path]:c.value})}>Set ${h.map(([u,d])=>`${In(u)} = ${d}`).join(", ")}</button>`:""}<button class="btn" @click=${()=>n.refuse(null)}>Close</button></div></div>`:""}
        ${!c&&o.length?$`<span></span><button class="hint link" @click=${()=>n.refuse(e.path,o[0])}>${o.map(u=>u.value).join(", ")} ${o.length===1?"is":"are"} refused: why?</button><span></span>`:""}</div>`}var Ar=[["1 2 3","layer, from the top"],["A B X","show A, show B, swap"],["C","compare with a copy, or stop"],["W S D K","wipe, side by side, ×10 difference, flicker"],["F L","furnace; turn the light"],["P","probe under the pointer"],["[ ]","exposure, a third of a stop"],["V","next view"],["Ctrl Z","undo; with Shift redo"],["?","all keys"]],On=["picture","lobe","slices","map","albedo","weights"];function _r(n){let t=n.options.keys??document,e=i=>{let r=i.composedPath()[0];if(r instanceof HTMLInputElement&&r.type!=="range"||r instanceof HTMLTextAreaElement||r instanceof HTMLSelectElement||i.altKey)return;let s=i.key.length===1?i.key.toLowerCase():i.key,o=n.two;if(i.ctrlKey||i.metaKey){s==="z"&&(i.preventDefault(),n.step(i.shiftKey?1:-1)),s==="y"&&(i.preventDefault(),n.step(1));return}let c=h=>()=>o&&n.set({cmp:h}),l={a:c("A"),b:c("B"),w:c("wipe"),s:c("side"),d:c("diff"),k:c("flick"),x:()=>n.swap(),c:()=>n.compare(),f:()=>n.set({furnace:!n.state.furnace}),l:()=>n.set({turn:(n.state.turn+195)%360-180},"turn"),"[":()=>n.set({ev:Math.round((n.state.ev-1/3)*1e3)/1e3},"ev"),"]":()=>n.set({ev:Math.round((n.state.ev+1/3)*1e3)/1e3},"ev"),p:()=>n.state.probe&&!n.pointer?n.set({probe:""}):n.pointer&&n.probe(...n.pointer),v:()=>n.set({view:On[(On.indexOf(n.state.view)+1)%On.length]}),"?":()=>{n.help=!n.help,n.update()},Escape:()=>{n.help=!1,n.picking="",n.state.probe&&n.set({probe:""}),n.update()}};if(/^[1-9]$/.test(s)){n.set({layer:Number(s)-1});return}l[s]&&(i.preventDefault(),l[s]())};return t.addEventListener("keydown",e),()=>t.removeEventListener("keydown",e)}async function Sr(n){let{canvas:t}=n.gpu;n.renderer.show();let e=await createImageBitmap(t),i=Math.round(t.width/60)+6,r=document.createElement("canvas");r.width=t.width,r.height=t.height+3*i;let s=r.getContext("2d");s.fillStyle="#141415",s.fillRect(0,0,r.width,r.height),s.drawImage(e,0,0),s.fillStyle="#ededef",s.font=`${i-6}px sans-serif`;let o=n.state,c=n.sides.map(u=>`${n.two?`${u.letter} `:""}${u.text()}`),l=`gonio ${n.start.gonio} · ${o.furnace?"furnace":o.env} · ${o.ev>=0?"+":"−"}${Math.abs(o.ev).toFixed(1)} EV · tone ${o.tone} · ${Math.min(...n.renderer.visible().map(u=>u.samples))} spp · ${n.gpu.name}`;[...c,l].slice(-3).forEach((u,d,g)=>s.fillText(u,8,t.height+i*(d+1+(3-g.length)/2)-4,r.width-16));let h=await new Promise(u=>r.toBlob(u,"image/png"));Pn(h,`${n.sides.map(u=>u.payload.name.replace(/\W+/g,"_")).join("_")}.png`)}function Pn(n,t){let e=document.createElement("a");e.href=URL.createObjectURL(n),e.download=t,e.click(),setTimeout(()=>URL.revokeObjectURL(e.href),1e4)}var zr={glsl:"GLSL",essl:"GLSL ES",hlsl:"HLSL",wgsl:"WGSL",msl:"Metal",slang:"Slang",osl:"OSL",cpp:"C++",cuda:"CUDA",mtlx:"MaterialX"},Qo=/(\/\/.*$)|\b(\d+\.?\d*(?:e[-+]?\d+)?[fu]?)\b|\b(struct|fn|let|var|const|return|if|else|for|float|vec2|vec3|vec2f|vec3f|f32|bool|float2|float3|inline|void|color|vector|int|constexpr|namespace|shader|interface)\b/g;function Xo(n){let t=[],e=0;for(let i of n.matchAll(Qo))t.push(n.slice(e,i.index),$`<i class=${i[1]?"co":i[2]?"nu":"kw"}>${i[0]}</i>`),e=i.index+i[0].length;return[...t,n.slice(e)]}function Ur(n){let t=n.edited(),{text:e,error:i}=n.code,r=!n.source.live,s=e?.split(`
`)??[],o=`gonio export '${t.payload?t.plainText():""}' --to ${n.language}`,c=r?["wgsl","essl"]:Object.keys(zr);return $`<div class="row"><div class="seg" role="group" aria-label="Language">${c.map(l=>$`<button aria-pressed=${n.language===l} @click=${()=>n.setLanguage(l)}>${zr[l]}</button>`)}</div><span class="sp"></span><span class="dim xs">${e?`${s.length-1} lines`:""}</span>
            <button class="btn" ?disabled=${!e} @click=${()=>Pn(new Blob([e],{type:"text/plain"}),`${t.payload.name.replace(/\W+/g,"_")}.${{cpp:"h",msl:"metal",cuda:"cuh"}[n.language]??n.language}`)}>Download</button><button class="btn" ?disabled=${!e} @click=${()=>n.copy(e,"The code")}>Copy</button></div>
        <pre tabindex="0" aria-label="Exported code"><code>${i?$`<i class="co">${i}</i>`:e?s.map(l=>$`${Xo(l)}\n`):"…"}</code></pre>
        <div class="cmd"><code>${o}</code><button class="btn" @click=${()=>n.copy(o,"The command")}>Copy command</button></div>`}function Tr(n){let t=n.edited();return t.payload?$`${t.payload.about.map(e=>$`<div class="about"><div><h3>${e.title||e.name}</h3>${e.description.split(`

`).map(i=>$`<p>${i.replaceAll(`
`," ")}</p>`)}${e.source?$`<p class="source">Source: ${e.source}</p>`:""}</div>
        <div><h3>Promised, and measured by gonio check</h3><ul class="y">${e.claims.filter(i=>i.kind==="promised").map(i=>$`<li>${i.text}</li>`)}</ul></div>
        <div><h3>Known to be wrong</h3><ul>${[...e.claims.filter(i=>i.kind!=="promised").map(i=>i.text),...e.caveats].map(i=>$`<li>${i}</li>`)}</ul>${e.caveats.length+e.claims.filter(i=>i.kind!=="promised").length?"":$`<p>Nothing.</p>`}</div></div>`)}
        <div class="cmd"><code>gonio view ${n.sides.map(e=>`'${e.payload?e.plainText():""}'`).join(" ")}</code><button class="btn" @click=${()=>n.copy(`gonio view ${n.sides.map(e=>`'${e.plainText()}'`).join(" ")}`,"The command")}>Copy command</button></div>`:""}var ta=[["A","A"],["B","B"],["wipe","Wipe"],["side","Side"],["flick","Flicker"],["diff","×10"]],ea=[["picture","Picture"],["lobe","Lobe"],["slices","Slices"],["map","θh θd"],["albedo","Albedo"],["weights","Weights"]],Or=[["plots","Plots"],["code","Code"],["about","About"]],na=[["side","Layers","layers"],["light","Light","light"],["plots","Plots","plots"],["code","Code","code"],["about","About","info"]];function Pr(n){let t=n.edited(),e=t.payload,i=n.phone??"side";return $`<div class="page" data-t=${n.theme??(matchMedia("(prefers-color-scheme:light)").matches?"light":"dark")} @dragover=${r=>{r.preventDefault()}} @drop=${r=>{r.preventDefault();for(let s of[...r.dataTransfer.files].slice(0,2))n.take(s)}}>
        <div class="app" data-d=${n.state.dock} data-p=${["plots","code","about"].includes(i)?"dock":i}>
            ${ia(n)}${ra(n)}${pa(n)}${ga(n)}
            <aside class="side" aria-label="Material">${e?$`${$r(n)}${Mr(n)}`:$`<div class="sec">${t.error?$`<div class="note" role="alert">${ct("warn")}<div><b>${t.error.title}</b><p>${t.error.text}</p></div></div>`:$`<p class="dim">One moment …</p>`}</div>`}</aside>
            <nav class="ptabs" role="tablist" aria-label="Panels">${na.map(([r,s,o])=>$`<button role="tab" aria-selected=${i===r} @click=${()=>{n.phone=r,Or.some(([c])=>c===r)&&n.set({dock:r}),n.update()}}>${ct(o)}${s}</button>`)}</nav>
        </div>${n.help?va(n):""}${n.picking?xa(n):""}</div>`}function Nr(n,t){if(!t.payload)return"";let e=n.two?n.sides[t.letter==="A"?1:0]:null,i=[];for(let[r,s]of t.options)(e?.options?e.options.get(r)!==s:s!==t.startOf(r,s))&&i.push(s);for(let r of t.payload.parameters){let s=t.values.get(r.path),o=e?.values?.get(r.path);(e?o&&o.some((c,l)=>c!==s[l]):t.changed(r.path))&&i.push(`${r.path} ${s.length===1?Number(s[0].toPrecision(3)):""}`.trim())}return i.slice(0,3).join(", ")||(t.payload.title||"").split(":")[0]}function Er(n,t){return $`<button class="chip ${t.letter}" title=${`Choose model ${t.letter}`} aria-label=${`Model ${t.letter}: ${t.text?.call&&t.payload?t.payload.name:""}. Choose another`} @click=${()=>{n.picking=t.letter,n.search="",n.update()}}><b>${t.letter}</b><span>${t.payload?.name??"…"}<small>${Nr(n,t)}</small></span></button>`}function ia(n){let t=n.state,e=()=>{let i=(n.theme??(matchMedia("(prefers-color-scheme:light)").matches?"light":"dark"))==="light";n.theme=i?"dark":"light",n.update()};return $`<header class="top"><div class="logo">gonio <span>view</span></div>${Er(n,n.sides[0])}
        ${n.two?$`<button class="ib u" aria-label="Swap A and B" title="Swap A and B (X)" @click=${()=>n.swap()}>${ct("swap")}</button>${Er(n,n.sides[1])}<button class="ib u" aria-label="Stop comparing" title="Stop comparing (C)" @click=${()=>n.compare(!1)}>${ct("close")}</button>`:$`<button class="btn u" title="Compare with a copy (C)" @click=${()=>n.compare(!0)}>Compare</button>`}
        <span class="sp"></span>${n.two?$`<div class="seg" role="group" aria-label="Compare">${ta.map(([i,r])=>$`<button aria-pressed=${t.cmp===i} @click=${()=>n.set({cmp:i})}>${r}</button>`)}</div><span class="sp"></span>`:""}
        <button class="ib u" aria-label="Undo" title="Undo (Ctrl Z)" ?disabled=${!n.history?.can(-1)} @click=${()=>n.step(-1)}>${ct("undo")}</button><button class="ib u" aria-label="Redo" title="Redo (Ctrl Shift Z)" ?disabled=${!n.history?.can(1)} @click=${()=>n.step(1)}>${ct("redo")}</button>
        <button class="btn t" @click=${()=>n.copy(n.link(),"The link")}>Copy link</button><button class="btn t" @click=${()=>n.savePicture()}>Save picture</button><button class="ib" aria-label="Light or dark" title="Light or dark" @click=${e}>${ct("light")}</button></header>`}function ra(n){let t=n.state,e=n.two&&t.cmp==="wipe"&&t.view==="picture",i=n.two&&["wipe","side"].includes(t.cmp)&&t.view==="picture";return $`<main class="stage" aria-label="Picture" data-c=${n.two?t.cmp:"A"} .style=${`--w:${t.cmp==="side"?50:100*t.wipe}%`}>
        <div class="canvas" tabindex="0" role="img" aria-label=${`${n.sides.map(r=>r.payload?.name).join(" and ")} under ${t.furnace?"the furnace":t.env}. Arrows turn the camera.`} @pointerdown=${r=>la(n,r)} @pointermove=${r=>aa(n,r)} @pointerleave=${()=>{n.pointer=null}} @wheel=${r=>{r.preventDefault(),n.set({dist:Math.min(40,Math.max(2.5,t.dist*Math.exp(r.deltaY*.001)))},"dist")}} @keydown=${r=>ca(n,r)} @dblclick=${r=>{let s=Ln(n,r);s&&n.probe(...s)}}></div>
        ${t.view!=="picture"?ua(n):""}
        ${e?$`<div class="wipe" role="slider" tabindex="0" aria-orientation="horizontal" aria-label="Wipe between A and B" aria-valuemin="0" aria-valuemax="100" aria-valuenow=${Math.round(100*t.wipe)} @pointerdown=${r=>ha(n,r)} @keydown=${r=>{let s={ArrowLeft:-1,ArrowRight:1}[r.key];s&&(r.preventDefault(),r.stopPropagation(),n.set({wipe:Math.min(1,Math.max(0,t.wipe+s*(r.shiftKey?.1:.01)))},"wipe"))}}><i>${ct("wipe")}</i></div>`:""}
        ${i?n.sides.map(r=>$`<div class="glass tag ${r.letter}"><b class="k ${r.letter==="B"?"kb":""}">${r.letter}</b><span>${Nr(n,r)}</span></div>`):""}
        <div class="glass views" role="tablist" aria-label="View">${ea.map(([r,s])=>$`<button role="tab" aria-selected=${t.view===r} @click=${()=>n.set({view:r})}>${s}</button>`)}</div>
        ${sa(n)}${t.view==="picture"?fa(n):""}${oa(n)}
        ${n.notes.length?$`<div class="notes" aria-live="polite">${n.notes.map(r=>$`<div class="glass note1 ${r.kind}">${ct(r.kind==="warn"?"warn":"info")}<div><b>${r.title}</b>${r.text?$`<p>${r.text}</p>`:""}</div><button class="ib" aria-label="Close message" @click=${()=>n.dismiss(r)}>${ct("close")}</button></div>`)}</div>`:""}
        <div class="glass keys">${n.two?$`<span><kbd>W</kbd>wipe</span>`:$`<span><kbd>C</kbd>compare</span>`}<span><kbd>F</kbd>furnace</span><button @click=${()=>{n.help=!0,n.update()}}><kbd>?</kbd>all keys</button></div></main>`}function sa(n){let t=n.renderer?.settings?n.renderer.visible():[],e=Math.min(...t.map(s=>s.shown||0),1/0),i=n.statistics?.sides,r=i?.length?Math.max(...i.map(s=>s.noise)):null;return $`<div class="glass qual" title="Samples per pixel, noise of the mean, time per pass"><i class="h" .style=${`--q:${Number.isFinite(e)?100*e/n.renderer.limit:0}%`}></i><span><b>${Number.isFinite(e)?e:0}</b> <span class="dim">spp</span></span>
        ${r===null?"":$`<span><b>${r<.1?lt(100*r,1):Math.round(100*r)} %</b> <span class="dim">noise</span></span>`}${n.renderer?$`<span class="h"><b>${n.renderer.ms<100?lt(n.renderer.ms,1):Math.round(n.renderer.ms)}</b> <span class="dim">ms</span></span>`:""}<span class="dim h" title=${n.gpu?.adapter??""}>${n.gpu?.name??"no GPU"}</span></div>`}function oa(n){let t=n.statistics;return!t||n.state.view!=="picture"?"":$`<div class="glass cmp" title="Linear values, whole picture, no tone curve">${t.rmse===null?"":$`<span><span class="dim">RMSE</span><b>${lt(t.rmse)}</b></span>`}${t.sides.map(e=>$`<span class="h"><span class="dim">mean ${n.two?e.letter:""}</span><b class="thin">${lt(e.mean)}</b></span>`)}</div>`}function Ln(n,t){let e=t.currentTarget.getBoundingClientRect(),i=(t.clientX-e.left)/e.width,r=(t.clientY-e.top)/e.height;return n.two&&n.state.cmp==="side"&&(i=i*2%1),i>=0&&i<=1&&r>=0&&r<=1?[i,r]:null}function aa(n,t){n.pointer=Ln(n,t)}function la(n,t){let e=t.currentTarget,{az:i,el:r}=n.state,[s,o]=[t.clientX,t.clientY],c=Ln(n,t),l=!1;e.setPointerCapture(t.pointerId);let h=d=>{if(!l&&Math.hypot(d.clientX-s,d.clientY-o)<4)return;l=!0;let g=(i-(d.clientX-s)*.4+540)%360-180;n.set({az:Math.round(g*10)/10,el:Math.round(Math.min(85,Math.max(n.state.furnace?-85:-2,r+(d.clientY-o)*.3))*10)/10},"camera")},u=()=>{e.removeEventListener("pointermove",h),e.removeEventListener("pointerup",u),!l&&c&&matchMedia("(pointer:coarse)").matches&&n.probe(...c)};e.addEventListener("pointermove",h),e.addEventListener("pointerup",u)}function ca(n,t){let e={ArrowLeft:[-5,0],ArrowRight:[5,0],ArrowUp:[0,3],ArrowDown:[0,-3]}[t.key];e&&(t.preventDefault(),n.set({az:(n.state.az+e[0]+540)%360-180,el:Math.min(85,Math.max(-2,n.state.el+e[1]))},"camera"))}function ha(n,t){let e=t.currentTarget,i=e.parentNode.getBoundingClientRect();t.preventDefault(),e.setPointerCapture(t.pointerId);let r=s=>n.set({wipe:Math.round(Math.min(1,Math.max(0,(s.clientX-i.left)/i.width))*1e3)/1e3},"wipe");e.onpointermove=r,e.onpointerup=()=>{e.onpointermove=null}}var Ir=n=>`${lt(Math.acos(Math.max(-1,Math.min(1,n)))*180/Math.PI,1)}°`;function fa(n){let t=n.probed;if(!n.state.probe||!t)return"";let[e,i]=n.renderer.pictureSize(n.state),r=n.two&&n.state.cmp==="side",s=r?t.x/2:t.x,o=$`<span class="hair" aria-hidden="true" .style=${`left:${100*s}%;top:${100*t.y}%`}></span>`,c=s>.6?"west":"",l=$`<button class="xs dim" title="Close (P or Esc)" @click=${()=>n.set({probe:""})}><kbd>P</kbd>close</button>`,h=$`<h3>Probe <span class="dim">pixel ${Math.floor(t.x*e)}, ${Math.floor(t.y*i)}</span><span class="sp"></span>${l}</h3>`;if(!t.found)return $`${o}<section class="glass probe ${c}" aria-label="Probe">${h}<p class="dim">Not on the material.</p></section>`;let{wi:u,wo:d}=t.found,g=Math.atan2(u[1],u[0])-Math.atan2(d[1],d[0]),k=Math.abs((g*180/Math.PI+540)%360-180),v=p=>p.letter==="B"?"isB":"";return $`${o}<section class="glass probe ${c}" aria-label="Probe">${h}
        <table class="dirs"><tbody>${[["ωi",u],["ωo",d]].map(([p,w])=>$`<tr><td>${p}</td>${w.map(b=>$`<td>${lt(b,3)}</td>`)}</tr>`)}<tr><td>angles</td><td colspan="3">θi ${Ir(u[2])}&ensp;θo ${Ir(d[2])}&ensp;φ ${lt(k,1)}°</td></tr></tbody></table><hr>
        <table><tbody><tr><th scope="col"><span class="sr">Quantity</span></th><th scope="col">R</th><th scope="col">G</th><th scope="col">B</th></tr>
            ${t.values.map(p=>$`<tr class=${v(p)} data-probe=${`f${p.letter}`}><td>f${n.two?$`&ensp;${p.letter}`:""}</td>${p.f.map(w=>$`<td data-value=${w}>${lt(w)}</td>`)}</tr>`)}
            ${t.values.map(p=>$`<tr class=${v(p)} data-probe=${`albedo${p.letter}`}><td>albedo ${n.two?p.letter:""}</td>${p.albedo.map(w=>$`<td data-value=${w}>${lt(w)}</td>`)}</tr>`)}
            ${t.values.length?$`<tr data-probe="pdf"><td>pdf</td><td colspan="3">${t.values.map(p=>lt(p.pdf)).filter((p,w,b)=>b.indexOf(p)===w).join(", ")} /sr${t.values.length===2&&lt(t.values[0].pdf)===lt(t.values[1].pdf)?", both":""}</td></tr>`:""}</tbody></table></section>`}var Oe=n=>$`<label class="thetao">θo <b>${Math.round(n.state.theta)}°</b><input type="range" min="0" max="89" step="1" aria-label="Angle of the viewer" .value=${String(n.state.theta)} .style=${`--f:${100*n.state.theta/89}%`} @input=${t=>n.set({theta:t.target.valueAsNumber},"theta")}></label>`,Nn=n=>$`<select class="channel" aria-label="Channel" .value=${String(n.channel)} @change=${t=>{n.channel=Number(t.target.value),n.update()}}>${zn.map((t,e)=>$`<option value=${e} ?selected=${e===n.channel}>${t}</option>`)}</select>`;function ua(n){let t=n.state,e=n.plots(),i=(o,c)=>$`<label class="check"><input type="checkbox" .checked=${n.lobe[o]} @change=${l=>{n.lobe[o]=l.target.checked,n.update()}}>${c}</label>`,r=o=>{let c=o.currentTarget,{az:l,el:h}=n.lobe,[u,d]=[o.clientX,o.clientY];c.setPointerCapture(o.pointerId),c.onpointermove=g=>{n.lobe.az=l-(g.clientX-u)*.5,n.lobe.el=Math.min(90,Math.max(-10,h+(g.clientY-d)*.4)),n.update()},c.onpointerup=()=>{c.onpointermove=null}};return $`<div class="large">${{lobe:()=>$`<canvas class="lobe" role="img" aria-label="The lobe f cos theta for the chosen viewer" @pointerdown=${r}></canvas><div class="bar">${Oe(n)}${i("log","log radius")}${i("weights","samples, coloured by f cos θ / pdf")}${Cr()}</div>`,slices:()=>$`<div class="pair">${e.length?$`${fe(n,"polar-large","Polar slice of f cos theta",(o,c)=>Tn(e,n.channel,o,c))}${fe(n,"cartesian-large","f cos theta over theta, log scale",(o,c)=>mr(e,n.channel,o,c))}`:""}</div><div class="bar">${Oe(n)}${Nn(n)}<span class="dim xs">f cos θi in the plane of ωo and the normal, 1/sr, logarithmic</span></div>`,map:()=>$`<div class="pair maps">${Lr(n)}</div><div class="bar"><span class="dim xs">f over the half angle θh (across) and the difference angle θd (up), φd = 90°; white is the 95th percentile</span></div>`,albedo:()=>$`${e.length?fe(n,"albedo-large","Directional albedo",(o,c)=>En(e,n.channel,o,c,t.theta)):""}<div class="bar">${Oe(n)}${Nn(n)}</div>`,weights:()=>$`<canvas class="weights" role="img" aria-label="Samples of the model on the hemisphere, coloured by their weight"></canvas><div class="bar">${Oe(n)}${Cr()}<span class="dim xs">seen from above; a perfect sampler has one colour</span></div>`}[t.view]?.()??""}</div>`}var Cr=()=>$`<span class="heat xs">⅛<i></i>8 × weight</span>`,Lr=n=>n.plots().map(t=>$`<span class="map"><canvas data-map=${t.letter} role="img" aria-label=${`f of ${t.letter} over half and difference angle`}></canvas>${n.two?$`<b class="k ${t.letter==="B"?"kb":""}">${t.letter}</b>`:""}<small class="y">90°</small><small class="y0">θd</small><small class="x0">0°</small><small class="xm">θh</small><small class="x1">90°</small></span>`);function pa(n){let t=n.state,e=n.start.environments,i=()=>ma(n);return $`<section class="light" aria-label="Light"><button class="sw" role="switch" aria-checked=${t.furnace} title="Radiance 1 from everywhere (F)" @click=${()=>n.set({furnace:!t.furnace})}><i></i>Furnace</button>
        <div class="envs w">${Object.keys(e).map(r=>$`<button class=${`env-${r}`} aria-pressed=${t.env===r} title=${r} @click=${()=>n.set({env:r})}>${da(e[r])}<span>${r}</span></button>`)}${n.renderer?.sky?$`<button aria-pressed=${t.env==="own"} @click=${()=>n.set({env:"own"})}><span>own</span></button>`:""}<button class="drop h" aria-label="Open an HDR picture or a mesh" title="Drop .hdr, .exr, .obj or .glb anywhere, or choose a file" @click=${i}>Drop<br>HDR, OBJ</button></div>
        <div class="g"><label>Turn light<b>${Math.round(t.turn)}°</b></label><input type="range" class="bi" aria-label="Turn light" min="-180" max="180" .value=${String(t.turn)} @input=${r=>n.set({turn:r.target.valueAsNumber},"turn")} @dblclick=${()=>n.set({turn:0})}></div>
        <div class="g"><label>Exposure<b>${t.ev<0?"−":"+"}${Math.abs(t.ev).toFixed(1)} EV</b></label><input type="range" class="bi" aria-label="Exposure" min="-6" max="6" step=".1" .value=${String(t.ev)} @input=${r=>n.set({ev:r.target.valueAsNumber},"ev")} @dblclick=${()=>n.set({ev:0})}></div>
        <div class="g tone"><select aria-label="Tone curve" .value=${t.tone} @change=${r=>n.set({tone:r.target.value})}>${["none","reinhard","filmic"].map(r=>$`<option value=${r} ?selected=${r===t.tone}>Tone: ${r}</option>`)}</select></div>
        <div class="g shape"><select aria-label="Shape" .value=${t.shape} @change=${r=>r.target.value==="open"?i():n.set({shape:r.target.value})}>${[["ball","Ball"],["sphere","Sphere"],...n.renderer?.own?[["own","Own mesh"]]:[],["open","Open mesh …"]].map(([r,s])=>$`<option value=${r} ?selected=${r===t.shape}>${s}</option>`)}</select></div></section>`}function da(n){let t=({centre:[r,s,o]})=>{let c=Math.hypot(r,s,o);return[29+Math.atan2(r,o)/Math.PI*29,16-Math.asin(s/c)/Math.PI*32]},e=Math.round(255*Math.min(1,(n.surround[1]||.05)**.45)),i=!!n.picture;return ot`<svg viewBox="0 0 58 32" preserveAspectRatio="none" aria-hidden="true"><rect width="58" height="32" fill=${i?"#4d7fb8":`rgb(${e} ${e} ${e})`}></rect><rect y=${i?17:20} width="58" height="15" fill=${i?"#8a8780":`rgb(${e*.8} ${e*.8} ${e*.8})`}></rect>
        ${n.lamps.map(r=>{let[s,o]=t(r),c=Math.min(7,Math.max(1.6,Math.sqrt(r.area)/Math.hypot(...r.centre)*9));return r.shape==="disk"?ot`<circle cx=${s} cy=${o} r=${Math.max(c/2,1.8)} fill="#fff"></circle>`:ot`<rect x=${s-c} y=${o-c/2} width=${2*c} height=${c} fill="#fff"></rect>`})}</svg>`}function ma(n){let t=document.createElement("input");t.type="file",t.accept=".hdr,.exr,.obj,.glb",t.onchange=()=>t.files[0]&&n.take(t.files[0]),t.click()}function ga(n){let t=n.state,e=n.plots(),i=(s,o,c)=>$`<figcaption>${s}<span>${o}</span><button class="ib" aria-label=${`Show ${s} large`} title="Show large" @click=${()=>n.set({view:c})}>${ct("large")}</button></figcaption>`,r=()=>$`<div class="plots"><figure>${i("Lobe slice","f cos θi, log radius, 1/sr","slices")}${e.length?fe(n,"polar","Slice of the lobe, logarithmic radius",(s,o)=>Tn(e,n.channel,s,o)):""}</figure>
        <figure>${i("Albedo",`over θo, ${zn[n.channel]}`,"albedo")}${e.length?fe(n,"albedo","Directional albedo",(s,o)=>En(e,n.channel,s,o,t.theta)):""}</figure>
        <figure>${i("Half and difference angle","f","map")}<div class="maps">${Lr(n)}</div></figure></div>`;return $`<section class="dock"><div class="tabs" role="tablist" aria-label="Dock">${Or.map(([s,o])=>$`<button role="tab" aria-selected=${t.dock===s} @click=${()=>n.set({dock:s})}>${o}</button>`)}<span class="sp"></span>${t.dock==="plots"?$`${Oe(n)}${Nn(n)}${n.two?$`<span class="xs dim row lg"><i class="la"></i>A<i class="lb"></i>B</span>`:""}`:""}</div>
        <div class="pane ${t.dock==="plots"?"":t.dock}">${t.dock==="plots"?r():t.dock==="code"?Ur(n):Tr(n)}</div></section>`}function va(n){return $`<div class="sheet1" @click=${t=>{t.target===t.currentTarget&&(n.help=!1,n.update())}}><section class="card" aria-label="All keys"><h2>Keys</h2><table>${Ar.map(([t,e])=>$`<tr><td>${t.split(" ").map(i=>$`<kbd>${i}</kbd>`)}</td><td>${e}</td></tr>`)}</table>
        <p class="dim xs">Drag turns the camera, the wheel moves it, a double click probes. Arrows move a slider by 1 %, with Shift by 10 %.</p><button class="btn" @click=${()=>{n.help=!1,n.update()}}>Close</button></section></div>`}function xa(n){let t=n.sides.find(o=>o.letter===n.picking)??n.sides[0],e=(n.search??"").toLowerCase(),i=n.start.catalogue.filter(o=>`${o.name} ${o.summary}`.toLowerCase().includes(e)),r=()=>{n.picking="",n.update()},s=o=>{r();let c=n.state.edit;n.state.edit=t.letter,n.chooseModel({prefix:""},o),n.state.edit=c};return $`<div class="sheet1 left" @click=${o=>{o.target===o.currentTarget&&r()}}><section class="card pick1" aria-label=${`Models for ${t.letter}`}><input class="n left" type="search" placeholder="Search models and materials" aria-label="Search" .value=${n.search??""} @input=${o=>{n.search=o.target.value,n.update()}} @keydown=${o=>{o.stopPropagation(),o.key==="Escape"&&r(),o.key==="Enter"&&i[0]&&s(i[0].name)}}>
        <div class="list">${i.map(o=>$`<button @click=${()=>s(o.name)} aria-current=${o.name===t.payload?.name}><b>${o.name}</b><small>${o.kind==="model"?"":`${o.kind} · `}${o.summary}</small></button>`)}${i.length?"":$`<p class="dim">Nothing is called “${n.search}”.</p>`}</div></section></div>`}var nn=class{constructor(t,e,i={}){Object.assign(this,{root:t,source:e,options:i,sizes:{},data:{},lobes:{},statistics:null,notes:[],code:{},language:"wgsl"}),this.state={...se},this.sides=[new Ae("A")],this.openColours=new Set,this.channel=3,this.lobe={az:-62,el:22,log:!0,weights:!0},this.asked=0}async open(){let{state:t,bad:e}=Ke(this.options.fragment??"");this.start=await this.source.start(),Object.assign(this.state,t),this.state.a||(this.state.a=this.start.show[0]??"eon"),!this.state.b&&!("a"in t)&&this.start.show[1]&&(this.state.b=this.start.show[1]),this.state.b&&!("cmp"in t)&&(this.state.cmp="wipe"),e.length&&this.say("This link was taken in part.",`Not understood: ${e.join(", ")}.`),this.state.env in this.start.environments||(this.state.env="studio");let{gpu:i,reason:r}=await wn(this.options.graphics).catch(s=>({gpu:null,reason:s.message}));return this.reason=r,i?this.#t(i):this.say("No picture can be drawn here.",r,"warn"),i?.name==="WebGL2"&&!this.options.graphics&&this.say("WebGL2 is used instead of WebGPU.",`${r} All views work; shaders compile more slowly.`),this.update(),await this.#e(),this.history=new Ye(this.#f()),this.openColours.add(this.edited().payload?.parameters.find(s=>s.kind==="reflectance")?.path),this.source.watch(s=>this.#p(s)),this.update(),this}#t(t){this.renderer?this.renderer.replace(t):(this.renderer=new je(t,this.start,e=>this.#m(e)),this.renderer.sides=this.sides,this.renderer.failed=e=>this.say("The picture stopped.",e.message,"warn"),this.renderer.run()),this.gpu=t,t.lost.then(e=>{(t===this.gpu&&!this.closed&&e.reason!=="destroyed"||this.testLoss)&&this.#s(t)})}async#s(t){if(this.closed||t!==this.gpu)return;this.testLoss=!1,this.gpu=null;let e=await wn(this.options.graphics).catch(i=>({reason:i.message}));if(!e.gpu){this.say("The GPU was lost.",`${e.reason} The last picture stays.`,"warn");return}this.#t(e.gpu),this.update(),await Promise.all(this.sides.map(i=>this.#r(i))),this.say("The GPU was lost and is back.","Everything was restored from the page's state; the picture starts again."),this.moved(!1)}get two(){return this.sides.length>1}async#e(){!!this.state.b!==this.two&&(this.sides.length=1,this.state.b&&this.sides.push(new Ae("B")),this.two||Object.assign(this.state,{cmp:"A",edit:"A"})),await Promise.all(this.sides.map(t=>this.#i(t,this.state[t.letter.toLowerCase()])))}async#i(t,e){let i=t.turn=(t.turn??0)+1,r=setTimeout(()=>{t.busy="compiling …",this.update()},200);try{let s=await this.source.model(e);if(t.turn!==i)return!1;let o=t.payload,c=o&&{program:t.program,values:t.values,options:t.options,models:t.models},l=o&&Fr(o.code,s.code)&&Fr(o.hooks,s.hooks);if(t.take(s),!l||!t.program){try{await this.#r(t,i)}catch(h){throw o&&Object.assign(t,{payload:o,...c}),new Error(`This GPU's driver refuses the shader: ${h.message}`)}if(t.turn!==i)return!1}return t.error="",this.state[t.letter.toLowerCase()]=t.text(),this.#c(t),this.moved(),!0}catch(s){if(t.turn!==i)return!1;if(t.error={title:e.length>80?`${e.slice(0,77)}…`:e,text:`${s.message} ${t.payload?"The picture is of the last model that worked.":""}`},!t.payload){let o=this.start.show.find(l=>l!==e)??"eon",{error:c}=t;e!==o&&await this.#i(t,o)&&(t.error=c,this.say(`${c.title} cannot be shown.`,`${s.message} ${o} is shown instead.`,"warn"))}return!1}finally{clearTimeout(r),t.turn===i&&(t.busy=""),this.update()}}async#r(t,e=t.turn){if(!this.gpu)return;let{gpu:i}=this,r=await this.#n(t),s=await i.compile(r.payload);if(t.turn!==e||i!==this.gpu)return;t.active=r;let o=t.program;t.program=s,t.samples=0,t.epoch=-1,o&&o.model&&t.film&&setTimeout(()=>i.forget(o),2e3)}async#n(t){if(!t.hidden.size)return{payload:t.payload,path:c=>c};let e=Vt(t).filter(c=>!t.hidden.has(c.prefix)),i=[],r=[];e.forEach((c,l)=>{let h=e.slice(1,l+1).map(u=>u.prefix.slice(0,-1).split(".").pop());r.push(h.join(".")),l&&i.push(`${h.join(".")}=${c.model}`)}),e.forEach((c,l)=>{let h=r[l]?`${r[l]}.`:"";for(let u of t.payload.options)u.path.startsWith(c.prefix)&&!u.path.slice(c.prefix.length).includes(".")&&i.push(`${h}${u.path.slice(c.prefix.length)}=${t.options.get(u.path)}`)});let s=await this.source.model(`${e[0].model}${i.length?`:${i.join(",")}`:""}`),o=c=>{let l=c.lastIndexOf("."),h=r.indexOf(l<0?"":c.slice(0,l));return e[h].prefix+c.slice(l+1)};return{payload:{...s,hooks:[]},path:o}}async#c(t){let{payload:e}=t;if(!(!this.source.live||!e.options.length))try{let i=await this.source.options(t.text());t.payload===e&&(e.options=i.map(r=>({...r,value:t.options.get(r.path)})),this.update())}catch{}}async#p({file:t}){for(let e of this.sides)e.payload?.name===t&&await this.#i(e,e.text())&&this.say(`${t} was read again.`,"","info",3e3)}edited(){return this.state.edit==="B"&&this.two?this.sides[1]:this.sides[0]}#l(){return this.state.edit==="AB"&&this.two?this.sides:[this.edited()]}layerIndex(){return Math.min(this.state.layer,Vt(this.edited()).length-1)}differs(t){if(!this.two||!this.sides[1].payload||!this.sides[0].payload)return!1;let[e,i]=this.sides.map(r=>r.options.get(t));return e!==void 0&&i!==void 0&&e!==i}set(t,e=""){Object.assign(this.state,t),["furnace","env","turn","shape","az","el","dist"].some(r=>r in t)?this.moved():this.renderer?.refresh(this.state),"cmp"in t&&this.moved(!1),("theta"in t||"view"in t||"dock"in t)&&this.#u(),"dock"in t&&this.#d(),this.#a(e||Object.keys(t).join()),this.update()}setParameter(t,e){this.setParameters({[t]:e})}setParameters(t){this.fieldError=null;for(let e of this.#l()){for(let[i,r]of Object.entries(t))e.values.has(i)&&e.values.set(i,r.slice());this.state[e.letter.toLowerCase()]=e.text()}this.moved(),this.#a(Object.keys(t).join()),this.options.changed?.(this),this.update()}resetParameter(t){let e=this.edited().parameter(t);this.setParameter(t,this.edited().startOf(t,e.default))}async setOptions(t){this.refused=null;for(let e of this.#l()){let i=Object.fromEntries(Object.entries(t).filter(([r])=>e.options.has(r)||e.models.has(r)));!Object.keys(i).length||await this.#o(e,e.text(i))||await this.#h(e,i)}}async#h(t,e){await this.#c(t);for(let[i,r]of Object.entries(e)){let s=t.payload?.options.find(o=>o.path===i)?.values.find(o=>o.value===r&&!o.allowed);if(s){t.error="",this.refuse(i,s);return}}}async#o(t,e){let i=await this.#i(t,e);return i&&(this.#a(),this.options.changed?.(this)),this.update(),i}chooseModel(t,e){for(let i of this.#l())i.hidden.clear(),t.prefix?this.#o(i,i.text({[t.prefix.slice(0,-1)]:e})):this.#o(i,e)}resetLayer({prefix:t}){let e=this.edited(),i=o=>o.startsWith(t)&&!o.slice(t.length).includes("."),r={},s={};for(let o of e.payload.parameters)i(o.path)&&(r[o.path]=e.startOf(o.path,o.default));for(let o of e.payload.options){let c=e.startOf(o.path,o.default);i(o.path)&&e.options.get(o.path)!==c&&(s[o.path]=c)}this.setParameters(r),Object.keys(s).length&&this.setOptions(s)}addCoat(){for(let t of this.#l()){let[e,i]=Br(t.plainText());if(!this.start.catalogue.some(s=>s.kind==="model"&&s.name===e)){this.say("A coat cannot go over this.",`${t.payload.name} is a file or a material with textures; coats go over gonio's models.`,"warn");continue}t.hidden.clear();let r=i.map(s=>`base.${s}`);this.#o(t,`weidlich_wilkie:alpha=0.02,transmission=both_ways,solid_angle=compressed,base=${e}${r.map(s=>`,${s}`).join("")}`).then(()=>this.set({layer:0}))}}removeLayer(t){for(let e of this.#l()){let i=Vt(e),r=i.findIndex(u=>u.prefix===t.prefix),s=i[r+1];if(!s)continue;let[o,c]=Br(e.plainText()),l=s.prefix.slice(0,-1),h=[];for(let u of c){let[d]=u.split("=");if(d===l){t.prefix&&h.push(`${t.prefix.slice(0,-1)}=${s.model}`);continue}d.startsWith(s.prefix)?h.push(t.prefix+u.slice(s.prefix.length)):(!d.startsWith(t.prefix)||t.prefix&&d===t.prefix.slice(0,-1))&&d!==t.prefix.slice(0,-1)&&h.push(u)}e.hidden.clear(),this.#o(e,`${t.prefix?o:s.model}${h.length?`:${h.join(",")}`:""}`)}}async hide(t){for(let e of this.#l()){e.hidden.delete(t)||e.hidden.add(t);try{await this.#r(e)}catch(i){this.say("This layer cannot be hidden.",i.message,"warn"),e.hidden.clear()}}this.moved(!1),this.update()}async compare(t=!this.two,e=""){t&&!this.two?(this.state.b=e||this.sides[0].text(),this.state.cmp="wipe",this.state.edit="B"):t||Object.assign(this.state,{b:"",cmp:"A",edit:"A"}),await this.#e(),this.#a(),this.moved(!1),this.options.changed?.(this),this.update()}swap(){this.two&&(this.sides.reverse(),this.sides.forEach((t,e)=>{t.letter="AB"[e],this.state["ab"[e]]=t.text()}),this.renderer?.refresh(this.state),this.#u(),this.#a(),this.update())}toggleColour(t){this.openColours.delete(t)||this.openColours.add(t),this.update()}refuse(t,e){this.refused=t&&{path:t,...e},this.update()}fail(t){this.fieldError=t,this.update()}say(t,e="",i="info",r=0){let s={title:t,text:e,kind:i};this.notes=[...this.notes.slice(-2),s],r&&setTimeout(()=>this.dismiss(s),r),this.update()}dismiss(t){this.notes=this.notes.filter(e=>e!==t),this.update()}moved(t=!0){this.renderer?.restart({...this.state},{moving:t}),this.statistics=null,this.#u(),this.#d()}#f(){return{...this.state}}#a(t){this.history?.add(this.#f(),t),this.options.linked?.(Ve(this.state))}async step(t){let e=this.history.step(t);if(e){Object.assign(this.state,e);for(let i of this.sides)i.hidden.clear();await this.#e(),this.moved(!1),this.options.linked?.(Ve(this.state)),this.options.changed?.(this),this.update()}}link(){return`${this.options.address??location.href.split("#")[0]}#${Ve(this.state)}`}show(t,e="a"){let i=this.sides[e==="a"?0:1];return i&&i.text()!==t?this.#o(i,t):null}async follow(t){return!t==!this.two?t?this.show(t,"b"):null:this.compare(!!t,t)}async copy(t,e){try{await navigator.clipboard.writeText(t),this.say(`${e} is copied.`,"","info",2500)}catch{this.say(`${e} could not be copied; here it is.`,t)}}savePicture(){return Sr(this)}async take(t){try{let e=await sr(t);e.picture?(this.renderer.sky=e.picture,this.set({env:"own",furnace:!1}),this.moved(!1)):(this.renderer.own=e,this.renderer.scenes.clear(),this.set({shape:"own"}),this.moved(!1)),this.say(`${t.name} is shown.`,e.note??"","info",4e3)}catch(e){let i=/\.(obj|glb|gltf)$/i.test(t.name)?`The shape is still “${this.state.shape}”.`:`The light is still “${this.state.env}”.`;this.say(`${t.name} was not taken.`,`${e.message} ${i}`,"warn")}}#m(t){let e=t.samples;e>=4&&(e&e-1)===0&&t.scale===1&&this.#v(),this.#g()}#g(){this.progress??=setTimeout(()=>{this.progress=null,this.update()},150)}async#v(){let{epoch:t}=this.renderer;try{let e=await this.renderer.statistics();e&&this.renderer.epoch===t&&(this.statistics=e,this.update())}catch{}}#u(){clearTimeout(this.measuring),this.measuring=setTimeout(()=>this.#x(),60)}async#x(){if(!this.gpu||this.busyMeasuring){this.gpu&&this.#u();return}this.busyMeasuring=!0;try{for(let t of this.sides){if(!t.program)continue;let e=`${t.active.payload.text}|${JSON.stringify([...t.values])}|${this.state.theta}`,i=["lobe","weights"].includes(this.state.view);this.data[t.letter]?.key!==e&&(this.data[t.letter]={...await Fi(this.gpu,t,this.state.theta),letter:t.letter,key:e}),i&&this.lobes[t.letter]?.key!==e&&(this.lobes[t.letter]={...await Bi(this.gpu,t,this.state.theta),letter:t.letter,key:e})}await this.#w()}catch(t){this.gpu&&(this.plotError=t.message)}this.busyMeasuring=!1,this.update()}plots(){return this.sides.map(t=>this.data[t.letter]).filter(Boolean)}bodies(){return this.sides.map(t=>this.lobes[t.letter]).filter(Boolean)}probe(t,e){this.set({probe:`${t.toFixed(4)},${e.toFixed(4)}`},"probe"),this.#u()}async#w(){this.probed=null;let[t,e]=this.state.probe.split(",").map(Number);if(!this.state.probe||!Number.isFinite(t)||!Number.isFinite(e))return;let i=this.surface(t,e);if(this.probed={x:t,y:e,found:i,values:[]},!i)return;let{wi:r,wo:s}=i;for(let o of this.sides){if(!o.program)continue;let c=o.packed(i.growth===void 0?{}:o.overrides(i.uv,i.growth,i.t,o.mapData??o.maps())),l=await this.gpu.rows(o.program,c,_e([[r,s]])),h=await this.gpu.albedo(o.program,c,new Float32Array([...s,0]));this.probed.values.push({letter:o.letter,f:[...l.subarray(0,3)],pdf:l[3],albedo:[...h.subarray(0,3)]})}}surface(t,e){let[i,r]=this.renderer.pictureSize(this.state),s=this.renderer.view(this.state,i,r),{o,d:c}=di(s,t,e),l=this.renderer.scenes.get(this.renderer.sceneName);if(!l)return null;let h=ui(l,o,c),u=h?.t??1/0,d=!1;if(l.core){let I=l.core.centre.map((O,D)=>O-o[D]),G=$t(I,c),Y=Pt(I,mt(c,-G)),J=l.core.radius**2-$t(Y,Y);J>0&&G-Math.sqrt(J)>0&&G-Math.sqrt(J)<u&&(u=G-Math.sqrt(J),d=!0)}if(!Number.isFinite(u))return null;let g=Pt(o,mt(c,u)),k,v,p,w=.5;if(d)k=Ft(Pt(g,mt(l.core.centre,-1))),v=[-k[2],0,k[0]],p=[(Math.atan2(-k[0],-k[2])/(2*Math.PI)+1)%1,Math.acos(k[1])/Math.PI];else{let I=h.i,{places:G,looks:Y}=l;if(G[12*I+3]!==0)return null;let J=[1-h.u-h.v,h.u,h.v],O=X=>J[0]*Y[20*I+X]+J[1]*Y[20*I+4+X]+J[2]*Y[20*I+8+X];k=Ft([O(0),O(1),O(2)]),w=O(3);let D=[0,1,2].map(X=>[Y[20*I+12+2*X],Y[20*I+13+2*X]]);p=[0,1].map(X=>J[0]*D[0][X]+J[1]*D[1][X]+J[2]*D[2][X]);let Z=[...G.subarray(12*I+4,12*I+7)],V=[...G.subarray(12*I+8,12*I+11)],rt=[D[1][0]-D[0][0],D[1][1]-D[0][1]],nt=[D[2][0]-D[0][0],D[2][1]-D[0][1]];v=mt(Pt(mt(Z,nt[1]),mt(V,-rt[1])),Math.sign(rt[0]*nt[1]-rt[1]*nt[0]))}$t(k,c)>0&&(k=mt(k,-1)),v=Pt(v,mt(k,-$t(v,k)));let b=$t(v,v)>1e-16?Ft(v):Ft(Zt(Math.abs(k[1])>.99?[1,0,0]:[0,1,0],k)),A=Zt(k,b),T=I=>[$t(I,b),$t(I,A),$t(I,k)],B=T(mt(c,-1)),W=T(Ft(this.renderer.lightDirection(this.state,g)));return W[2]<=0&&(W=[-B[0],-B[1],B[2]]),{p:g,t:u,uv:p,growth:w,wi:W,wo:B}}#d(){this.state.dock==="code"&&(clearTimeout(this.coding),this.coding=setTimeout(()=>this.#y(),120))}async#y(){let t=this.edited();if(!t.payload)return;let e=t.text();try{this.code={text:await this.source.code(e,this.language),of:e}}catch(i){this.code={error:i.message}}this.update()}setLanguage(t){this.language=t,this.code={},this.#d(),this.update()}update(){this.drawing||this.closed||(this.drawing=!0,requestAnimationFrame(()=>{this.drawing=!1,this.closed||this.draw()}))}draw(){if(!this.start)return;ri(Pr(this),this.root);let t=this.root.querySelector(".canvas");this.gpu&&t&&this.gpu.canvas.parentNode!==t&&(t.replaceChildren(this.gpu.canvas),this.#b(t));let e=!1;for(let o of this.root.querySelectorAll("[data-chart]")){let c=o.clientWidth||o.getBoundingClientRect().width,l=o.clientHeight||o.getBoundingClientRect().height,h=this.sizes[o.dataset.chart];c&&(h?.width!==c||h?.height!==l)&&(this.sizes[o.dataset.chart]={width:c,height:l},e=!0)}let i=Math.min(devicePixelRatio,2);for(let o of this.root.querySelectorAll("canvas[data-map]")){let c=this.data[o.dataset.map];c&&o.drawn!==c.key&&(gr(o,c.map),o.drawn=c.key)}let r=this.root.querySelector("canvas.lobe"),s=this.root.querySelector("canvas.weights");r&&this.bodies().length&&vr(r,this.bodies(),this.lobe,i),s&&this.bodies().length&&wr(s,this.bodies(),i),e&&this.update()}#b(t){this.observer?.disconnect(),this.observer=new ResizeObserver(([e])=>{let i=e.devicePixelContentBoxSize?.[0],r=Math.min(devicePixelRatio,2)/devicePixelRatio,s=Math.max(16,Math.round((i?i.inlineSize:e.contentRect.width*devicePixelRatio)*r)),o=Math.max(16,Math.round((i?i.blockSize:e.contentRect.height*devicePixelRatio)*r)),{canvas:c}=this.gpu??{};!c||c.width===s&&c.height===o||(c.width=s,c.height=o,this.renderer.size=[s,o],this.renderer.show(),this.moved(!1))});try{this.observer.observe(t,{box:"device-pixel-content-box"})}catch{this.observer.observe(t)}this.unlisten??=_r(this)}close(){this.closed=!0,this.observer?.disconnect(),this.unlisten?.(),clearTimeout(this.measuring),this.renderer?.close()}},Fr=(n,t)=>JSON.stringify(n)===JSON.stringify(t);function Br(n){let t=n.indexOf(":");return t<0?[n,[]]:[n.slice(0,t),n.slice(t+1).split(",")]}async function Rr(n,t,e={}){let i=n.attachShadow({mode:"open"}),r=new CSSStyleSheet;return r.replaceSync(Wn),i.adoptedStyleSheets=[r],new nn(i,t,e).open()}async function wa(){let n=document.getElementById("gonio-data"),t=document.createElement("div");document.body.append(t),document.documentElement.style.height=document.body.style.height="100%",document.body.style.margin="0";let e=location.hash,i=/(?:^#|&)token=([\w-]+)/.exec(e)?.[1],r,s=c=>history.replaceState(null,"",`#${c}`);if(n){let c=Uint8Array.from(atob(n.textContent.trim()),h=>h.charCodeAt(0)),l=await new Response(new Blob([c]).stream().pipeThrough(new DecompressionStream("gzip"))).text();r=new He(JSON.parse(l))}else i&&sessionStorage.setItem("gonio-token",i),r=new De(i??sessionStorage.getItem("gonio-token")??"");let o=new URLSearchParams(location.search).get("graphics")??"";try{let c=e.replace(/(^#|&)token=[\w-]+&?/,"$1");globalThis.gonio=await Rr(t,r,{fragment:c,linked:s,graphics:o}),document.title=`${globalThis.gonio.sides.map(h=>h.text()).join(" | ").slice(0,120)} – gonio view`,addEventListener("hashchange",()=>{let{state:h}=Ke(location.hash);h.a&&location.reload()})}catch(c){t.textContent=c.message,t.style.cssText="font:15px sans-serif;padding:48px;max-width:60ch"}}async function ya({model:n,el:t}){let e=document.createElement("div");e.className="embedded",e.style.height=`${n.get("height")}px`,t.append(e);let i=()=>["a","b"].filter(c=>n.get(c)).map(c=>`${c}=${encodeURIComponent(n.get(c))}`).join("&"),r=c=>{for(let[l,h]of["a","b"].entries())n.set(h,c.sides[l]?.payload?c.sides[l].text():"");n.save_changes()},s=await Rr(e,new Ge(n),{fragment:`${i()}&${n.get("settings")}`,keys:e,changed:r,linked:c=>{n.set("link",c),n.save_changes()}}),o={"change:a":()=>s.show(n.get("a"),"a"),"change:b":()=>s.follow(n.get("b"))};for(let[c,l]of Object.entries(o))n.on(c,l);return()=>{for(let[c,l]of Object.entries(o))n.off(c,l);s.close()}}var tc={render:ya};(document.getElementById("gonio-data")||document.querySelector('script[src="/viewer.js"]'))&&wa();export{tc as default,Rr as mount};
