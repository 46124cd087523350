globalThis.r3gwPage=(require)=>{"use strict";(()=>{var __create=Object.create;var __defProp=Object.defineProperty;var __getOwnPropDesc=Object.getOwnPropertyDescriptor;var __getOwnPropNames=Object.getOwnPropertyNames;var __getProtoOf=Object.getPrototypeOf,__hasOwnProp=Object.prototype.hasOwnProperty;var __require=(x=>typeof require<"u"?require:typeof Proxy<"u"?new Proxy(x,{get:(a,b)=>(typeof require<"u"?require:a)[b]}):x)(function(x){if(typeof require<"u")return require.apply(this,arguments);throw Error('Dynamic require of "'+x+'" is not supported')});var __copyProps=(to,from,except,desc)=>{if(from&&typeof from=="object"||typeof from=="function")for(let key of __getOwnPropNames(from))!__hasOwnProp.call(to,key)&&key!==except&&__defProp(to,key,{get:()=>from[key],enumerable:!(desc=__getOwnPropDesc(from,key))||desc.enumerable});return to};var __toESM=(mod,isNodeMode,target)=>(target=mod!=null?__create(__getProtoOf(mod)):{},__copyProps(isNodeMode||!mod||!mod.__esModule?__defProp(target,"default",{value:mod,enumerable:!0}):target,mod));var pause=()=>new Promise(resolve=>setTimeout(resolve,0));function hasBlob(id){return document.getElementById(id)!==null}async function blob(id){let element=document.getElementById(id);if(!element)throw new Error(`this page lacks its part "${id}"`);let text=(element.textContent??"").trim();element.textContent="";let parts=[];for(let start2=0;start2<text.length;start2+=262144)parts.push(bytesOf(text.slice(start2,start2+262144))),await pause();let stream=new Blob(parts).stream().pipeThrough(new DecompressionStream("deflate"));return new Uint8Array(await new Response(stream).arrayBuffer())}async function jsonBlob(id){return JSON.parse(new TextDecoder().decode(await blob(id)))}function bytesOf(base64){let binary=atob(base64),bytes=new Uint8Array(binary.length);for(let i=0;i<binary.length;i++)bytes[i]=binary.charCodeAt(i);return bytes}var THREE=__toESM(__require("three"),1);function lensOf(photo){let[fx,fy,cx,cy]=photo.intrinsics,{width,height}=photo;return{fx:fx/height,fy:fy/height,right:(cx-width/2)/height,down:cy/height-.5,aspect:width/height}}function poseOf(photo){let m=photo.camFromWorld,rotation=new THREE.Matrix4().set(m[0][0],-m[1][0],-m[2][0],0,m[0][1],-m[1][1],-m[2][1],0,m[0][2],-m[1][2],-m[2][2],0,0,0,0,1);return{position:new THREE.Vector3(...[0,1,2].map(i=>-[0,1,2].reduce((sum,j)=>sum+m[j][i]*m[j][3],0))),quaternion:new THREE.Quaternion().setFromRotationMatrix(rotation)}}function frameIn(lens,canvasAspect){let relative=lens.aspect/canvasAspect;return relative<1?{width:relative,height:1}:{width:1,height:1/relative}}function project(camera,lens,canvasAspect,near,far){let frame=frameIn(lens,canvasAspect),[sx,sy]=[2*frame.width/lens.aspect,2*frame.height];camera.near=near,camera.far=far,camera.projectionMatrix.set(sx*lens.fx,0,-sx*lens.right,0,0,sy*lens.fy,sy*lens.down,0,0,0,-(far+near)/(far-near),-2*far*near/(far-near),0,0,-1,0),camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert()}var BINOMIAL=[1,5,10,10,5,1],LOWEST_DEG=.01;function clearDay(sun,tables){let pixels=new Float32Array(24576),elevationDeg=Math.max(sun.elevationDeg,LOWEST_DEG);return paintSky({...sun,elevationDeg},tables,pixels,128,64),addSun({...sun,elevationDeg},tables,pixels,128,64),paintGround(tables,pixels,128,64),{width:128,height:64,pixels}}function paintSky(sun,tables,pixels,width,height){let{params,radiance}=skyParameters(sun,tables),elevation=sun.elevationDeg*Math.PI/180,azimuth=sun.azimuthDeg*Math.PI/180;for(let row=0;row<height/2;row++){let theta=Math.PI*(row+.5)/height,upward=Math.cos(theta),root=Math.sqrt(upward);for(let column=0;column<width;column++){let phi=2*Math.PI*((column+.5)/width-.5),level=Math.sin(theta)*Math.cos(elevation)*Math.cos(phi-azimuth),cosine=Math.min(Math.max(level+upward*Math.sin(elevation),-1),1),gamma=Math.acos(cosine);for(let c=0;c<3;c++){let p=params[c],horizon=1+p[0]*Math.exp(p[1]/(upward+.01)),chi=(1+cosine**2)/(1+p[8]**2-2*p[8]*cosine)**1.5,glow=p[2]+p[3]*Math.exp(p[4]*gamma)+p[5]*cosine**2+p[6]*chi,value=horizon*(glow+p[7]*root)*radiance[c];pixels[3*(row*width+column)+c]=Math.max(value,0)}}}}function skyParameters(sun,tables){let[low,share]=between(sun.turbidity-1,tables.params.length),x=Math.cbrt(sun.elevationDeg/90),params=[0,1,2].map(()=>new Array(9).fill(0)),radiance=[0,0,0];return BINOMIAL.forEach((factor,k)=>{let weight=factor*(1-x)**(5-k)*x**k;for(let c=0;c<3;c++){let mix=(a,b)=>weight*((1-share)*a+share*b);radiance[c]+=mix(tables.radiance[low][k][c],tables.radiance[low+1][k][c]);for(let i=0;i<9;i++)params[c][i]+=mix(tables.params[low][k][c][i],tables.params[low+1][k][c][i])}}),{params,radiance}}function sunIrradiance(sun,tables){let[low,share]=between(sun.turbidity-1,tables.sunIrradiance.length),samples=tables.sunIrradiance[low].length,[at,step]=between(Math.sqrt(sun.elevationDeg/90)*(samples-1),samples);return[0,1,2].map(c=>{let along=t=>(1-step)*tables.sunIrradiance[t][at][c]+step*tables.sunIrradiance[t][at+1][c];return sun.strength*((1-share)*along(low)+share*along(low+1))})}function addSun(sun,tables,pixels,width,height){let irradiance=sunIrradiance(sun,tables),row=(90-sun.elevationDeg)/180*height-.5,column=((sun.azimuthDeg/360+.5)%1+1)%1*width-.5,[top,left]=[Math.floor(row),Math.floor(column)];for(let[i,down]of[[top,top+1-row],[top+1,row-top]])if(!(i<0))for(let[j,across]of[[left,left+1-column],[left+1,column-left]]){let at=3*(i*width+(j+width)%width),share=down*across/solidAngle(i,height);for(let c=0;c<3;c++)pixels[at+c]+=irradiance[c]*share}}function paintGround(tables,pixels,width,height){let level=[0,0,0];for(let row=0;row<height/2;row++){let weight=solidAngle(row,height)*Math.cos(Math.PI*(row+.5)/height);for(let column=0;column<width;column++)for(let c=0;c<3;c++)level[c]+=weight*pixels[3*(row*width+column)+c]}let ground=level.map((value,c)=>tables.ground[c]/Math.PI*value);for(let at=3*width*height/2;at<pixels.length;at++)pixels[at]=ground[at%3]}function solidAngle(row,height){let edge=i=>Math.cos(Math.PI*i/height);return(edge(row)-edge(row+1))*Math.PI/height}function between(position,count){let low=Math.min(Math.max(Math.floor(position),0),count-2);return[low,position-low]}function basis(x,y,z,norms,out){let cosine=1,sine=0,double=1;for(let m=0;m<=4;m++){let previous=0,current=double;for(let l=m;l<=4;l++){let at=l*l+l;out[at+m]=norms[at+m]*current*cosine,m>0&&(out[at-m]=norms[at-m]*current*sine);let following=((2*l+1)*z*current-(l+m)*previous)/(l-m+1);previous=current,current=following}[cosine,sine]=[x*cosine-y*sine,x*sine+y*cosine],double*=2*m+1}}function projected(map,degree,constants){let{width,height,pixels}=map,light=new Float64Array(75),values=new Float64Array(25),total=0;for(let row=0;row<height;row++){let theta=Math.PI*(row+.5)/height,sine=Math.sin(theta);for(let column=0;column<width;column++){let phi=2*Math.PI*((column+.5)/width-.5),x=sine*Math.sin(phi),z=sine*Math.cos(phi);basis(x,-Math.cos(theta),z,constants.shNorms,values);let at=3*(row*width+column);for(let i=0;i<(degree+1)**2;i++){let weight=sine*values[i];light[3*i]+=weight*pixels[at],light[3*i+1]+=weight*pixels[at+1],light[3*i+2]+=weight*pixels[at+2]}total+=sine}}return light.map(value=>value*4*Math.PI/total)}function turned(light,yaw,constants){if(yaw===0)return light;let count=light.length/3,result=new Float64Array(light.length);for(let k=0;k<=4;k++){let cosine=Math.cos(k*yaw),sine=Math.sin(k*yaw),[evens,odds]=[constants.yawCosines[k],constants.yawSines[k]];for(let i=0;i<count;i++)for(let j=0;j<count;j++){let factor=cosine*evens[i][j]+sine*odds[i][j];if(factor!==0)for(let c=0;c<3;c++)result[3*i+c]+=factor*light[3*j+c]}}return result}function mixed(a,b,share){return a.map((value,i)=>value+share*(b[i]-value))}function flat(rows,count){let light=new Float64Array(3*count);return rows.forEach((row,i)=>light.set(row,3*i)),light}var THREE2=__toESM(__require("three"),1),import_EXRLoader=__require("three/addons/loaders/EXRLoader.js"),import_HDRLoader=__require("three/addons/loaders/HDRLoader.js"),WIDEST=1024,LARGEST_HALF=65504,MapError=class extends Error{};async function readMap(file,gamma){let suffix=file.name.toLowerCase().split(".").pop()??"",map=await decodedMap(file,suffix,gamma);if(map.width!==2*map.height)throw new MapError(`${file.name} is ${map.width}×${map.height} px; a map of the surroundings is twice as wide as high`);let reduced=map;for(;reduced.width>WIDEST&&reduced.height%2===0;)reduced=halved(reduced);return reduced}async function decodedMap(file,suffix,gamma){try{return suffix==="exr"?fromLoader(new import_EXRLoader.EXRLoader().parse(await file.arrayBuffer()),!0):suffix==="hdr"?fromLoader(new import_HDRLoader.HDRLoader().parse(await file.arrayBuffer()),!1):await fromPicture(file,gamma)}catch(error){let kinds="give an .hdr, .exr, .jpg or .png file";throw new MapError(`${file.name} cannot be read as a picture (${String(error)}); ${kinds}`)}}function fromLoader(loaded,isUpsideDown){let{data,width,height,type}=loaded;if(!data||!width||!height)throw new Error("no pixels");let channels=data.length/(width*height),value=at=>type===THREE2.HalfFloatType?THREE2.DataUtils.fromHalfFloat(data[at]):data[at],pixels=new Float32Array(3*width*height);for(let row=0;row<height;row++){let from=(isUpsideDown?height-1-row:row)*width;for(let column=0;column<width;column++){let at=3*(row*width+column);for(let c=0;c<3;c++){let found=value(channels*(from+column)+(channels>=3?c:0));pixels[at+c]=Number.isFinite(found)?Math.max(found,0):0}}}return{width,height,pixels}}async function fromPicture(file,gamma){let bitmap=await createImageBitmap(file),{width,height}=bitmap,context=new OffscreenCanvas(width,height).getContext("2d");if(!context)throw new Error("no canvas");context.drawImage(bitmap,0,0);let bytes=context.getImageData(0,0,width,height).data,linear=Float32Array.from({length:256},(_,i)=>(i/255)**gamma),pixels=new Float32Array(3*width*height);for(let i=0;i<width*height;i++)for(let c=0;c<3;c++)pixels[3*i+c]=linear[bytes[4*i+c]];return{width,height,pixels}}function halved(map){let width=map.width/2,height=map.height/2,pixels=new Float32Array(3*width*height);for(let row=0;row<height;row++)for(let at=0;at<3*width;at++){let above=2*row*map.width*3+6*Math.floor(at/3)+at%3,below=above+3*map.width,p=map.pixels;pixels[3*row*width+at]=(p[above]+p[above+3]+p[below]+p[below+3])/4}return{width,height,pixels}}function textureOf(map){let count=map.width*map.height,halves=new Uint16Array(4*count);for(let i=0;i<count;i++)for(let c=0;c<3;c++){let value=Math.min(map.pixels[3*i+c],LARGEST_HALF);halves[4*i+c]=THREE2.DataUtils.toHalfFloat(value)}let texture2=new THREE2.DataTexture(halves,map.width,map.height,THREE2.RGBAFormat,THREE2.HalfFloatType);return texture2.wrapS=THREE2.RepeatWrapping,texture2.minFilter=texture2.magFilter=THREE2.LinearFilter,texture2.needsUpdate=!0,texture2}var TONES=["standard","reinhard","filmic"];var SHOWN=["picture","albedo","normals","depth","roughness","light"];var THREE3=__toESM(__require("three"),1);var vectors=count=>Array.from({length:count},()=>new THREE3.Vector3);function makeUniforms(payload){return{uTone:{value:0},uSky:{value:0},uSkyExposure:{value:1},uSkyYaw:{value:0},uSkyLight:{value:vectors(4)},uSkyMap:{value:null},uLight:{value:vectors(25)},uEye:{value:new THREE3.Vector3},uForward:{value:new THREE3.Vector3},uDepthRange:{value:new THREE3.Vector2(...payload.depthRange)},uNumForeground:{value:payload.numForeground},uShow:{value:0},uWithSpecular:{value:payload.withSpecular},uWithShadows:{value:payload.hasShadows},uForegroundShown:{value:!0},uSkyShown:{value:!0},uTableSize:{value:payload.tableSize},uTransferScale:{value:payload.transferScale},uSkyPerPixel:{value:!0},uRayFromNdc:{value:new THREE3.Matrix3}}}function setVectors(target,flat2){target.forEach((vector,i)=>vector.set(flat2[3*i],flat2[3*i+1],flat2[3*i+2]))}var WHITE_SKY=0,LEARNED_SKY=1,MAP_SKY=2,NO_SKY=3,WIDEST_PROJECTED=256,DARKEST_MEAN=1e-6,Lights=class{constructor(payload,uniforms){this.payload=payload;this.uniforms=uniforms;for(let{photo,light,sky}of payload.lights)this.learned.set(photo,{light:flat(light,25),sky:flat(sky,4)})}payload;uniforms;dropped=null;learned=new Map;own=null;ownKey="";texture=null;textureOwner=null;apply(state){let own=this.ownLight(state),{constants}=this.payload,yaw=state.yaw*Math.PI/180,exposure=this.exposure(state,own.light),light=turned(own.light,yaw,constants).map(value=>value*exposure),u=this.uniforms;setVectors(u.uLight.value,light),u.uTone.value=TONES.indexOf(state.tone),u.uShow.value=SHOWN.indexOf(state.show),u.uSkyExposure.value=exposure,u.uSkyYaw.value=yaw;let skyLight=state.sky==="learned"?this.learnedOf(state.photo).sky:own.skyLight;skyLight&&setVectors(u.uSkyLight.value,turned(skyLight,yaw,constants)),u.uSky.value=this.sky(state,own),u.uSkyMap.value=this.textureFor(own.map);let isDepth=state.show==="depth";u.uForegroundShown.value=state.parts!=="sky",u.uSkyShown.value=state.parts!=="foreground"&&(u.uSky.value!==NO_SKY||isDepth),u.uSkyPerPixel.value=u.uSky.value!==LEARNED_SKY&&!isDepth}exposure(state,light){let aim=this.payload.learnedMean,factor=2**state.stops;if(!state.auto||aim===null)return factor;let mean=light.slice(0,3).reduce((sum,value)=>sum+value,0)/3;return factor*aim/Math.max(mean,DARKEST_MEAN)}sky(state,own){return state.show!=="picture"||state.parts==="foreground"||state.sky==="none"?NO_SKY:state.sky==="white"?WHITE_SKY:state.sky==="learned"?LEARNED_SKY:own.map?MAP_SKY:own.skyLight?LEARNED_SKY:WHITE_SKY}ownLight(state){let{light,photo,photo2,blend,elevation,azimuth,strength,turbidity}=state,key=JSON.stringify(light==="learned"?[photo,photo2,blend]:light==="sun"?[elevation,azimuth,strength,turbidity]:light);if(this.own&&key===this.ownKey&&light!=="map")return this.own;if(this.ownKey=key,light==="sun"){let sun={elevationDeg:elevation,azimuthDeg:azimuth,strength,turbidity};this.own=this.fromMap(clearDay(sun,this.payload.daylight))}else light==="map"&&this.dropped?this.own?.map!==this.dropped&&(this.own=this.fromMap(this.dropped)):this.own=this.fromPhotos(photo,photo2,blend);return this.own}fromMap(map){let small=map;for(;small.width>WIDEST_PROJECTED&&small.height%2===0;)small=halved(small);return{light:projected(small,this.payload.lightDegree,this.payload.constants),skyLight:null,map}}fromPhotos(photo,photo2,blend){let a=this.learnedOf(photo),b=this.learnedOf(photo2||photo);return{light:mixed(a.light,b.light,blend),skyLight:mixed(a.sky,b.sky,blend),map:null}}learnedOf(photo){return this.learned.get(photo)??{light:grey(),sky:new Float64Array(12)}}textureFor(map){return map!==this.textureOwner&&(this.texture?.dispose(),this.texture=map?textureOf(map):null,this.textureOwner=map),this.texture}};function grey(){let light=new Float64Array(75);return light.fill(Math.sqrt(4*Math.PI),0,3),light}var import_spark=__require("@sparkjsdev/spark"),THREE4=__toESM(__require("three"),1);var float=value=>{let text=String(value);return/[.e]/.test(text)?text:`${text}.0`},array=values=>`float[${values.length}](${values.map(float).join(", ")})`,skySource=c=>`
uniform int uTone;
uniform int uSky; // 0 white, 1 learned, 2 map, 3 none
uniform float uSkyExposure;
uniform float uSkyYaw;
uniform vec3 uSkyLight[4];
uniform highp sampler2D uSkyMap;

vec3 displayFromLinear(vec3 linear) {
  return pow(clamp(linear, ${float(c.darkest)}, 1.0), vec3(1.0 / ${float(c.gamma)}));
}

vec3 toned(vec3 linear) {
  if (uTone == 1) {
    const float white = ${float(c.reinhardWhite)};
    linear = linear * (1.0 + linear / (white * white)) / (1.0 + linear);
  } else if (uTone == 2) {
    vec3 above = linear * (2.51 * linear + 0.03);
    linear = above / (linear * (2.43 * linear + 0.59) + 0.14);
  }
  return displayFromLinear(linear);
}

vec3 skySeen(vec3 d) {
  if (uSky == 0) return vec3(1.0);
  if (uSky == 3) return vec3(0.0);
  if (uSky == 1) {
    vec3 value = ${float(c.shNorms[0])} * uSkyLight[0] + ${float(c.shNorms[1])} *
      (d.y * uSkyLight[1] + d.z * uSkyLight[2] + d.x * uSkyLight[3]);
    vec3 display = clamp(value + 0.5, 0.0, 1.0);
    return toned(uSkyExposure * pow(display, vec3(${float(c.gamma)})));
  }
  const float pi = 3.14159265358979;
  float row = acos(clamp(-d.y, -1.0, 1.0)) / pi;
  float turn = (atan(d.x, d.z) - uSkyYaw) / (2.0 * pi) + 0.5;
  // The texture repeats sideways, so a turn beyond a circle is the same turn.
  return toned(uSkyExposure * textureLod(uSkyMap, vec2(turn, row), 0.0).rgb);
}
`,splatSource=c=>`
uniform highp sampler2D uPlace;
uniform highp usampler2D uShape;
uniform highp sampler2D uSurface;
uniform highp sampler2DArray uTransfer;
uniform highp sampler2D uTable;
uniform float uTableSize;
uniform float uTransferScale[28];
uniform vec3 uLight[25];
uniform vec3 uEye;
uniform vec3 uForward;
uniform vec2 uDepthRange;
uniform int uNumForeground;
uniform int uShow; // 0 picture, 1 albedo, 2 normals, 3 depth, 4 roughness, 5 light
uniform bool uWithSpecular;
uniform bool uWithShadows;
uniform bool uForegroundShown;
uniform bool uSkyShown;

const float kNorms[25] = ${array(c.shNorms)};
const float kCosineBands[3] = ${array(c.cosineBands)};

// The recursion of r3gw.lighting.sh.
void shBasis(vec3 d, out float y[25]) {
  float cosine = 1.0, sine = 0.0, doubled = 1.0;
  for (int m = 0; m <= 4; m++) {
    float previous = 0.0, current = doubled;
    for (int l = m; l <= 4; l++) {
      int at = l * l + l;
      y[at + m] = kNorms[at + m] * current * cosine;
      if (m > 0) y[at - m] = kNorms[at - m] * current * sine;
      float following = (float(2 * l + 1) * d.z * current - float(l + m) * previous) /
        float(l - m + 1);
      previous = current;
      current = following;
    }
    float turned = d.x * cosine - d.y * sine;
    sine = d.x * sine + d.y * cosine;
    cosine = turned;
    doubled *= float(2 * m + 1);
  }
}

// Irradiance of a surface before shadows (r3gw.lighting.irradiance).
vec3 irradiance(vec3 normal) {
  float y[25];
  shBasis(normal, y);
  vec3 sum = vec3(0.0);
  for (int l = 0; l <= 2; l++) {
    for (int i = l * l; i < (l + 1) * (l + 1); i++) sum += kCosineBands[l] * y[i] * uLight[i];
  }
  return max(sum, ${float(c.darkestIrradiance)});
}

// What shadows take from it, at most 0 for a light that is nowhere negative.
vec3 shadowed(ivec2 texel) {
  vec3 sum = vec3(0.0);
  for (int layer = 0; layer < 7; layer++) {
    vec4 levels = texelFetch(uTransfer, ivec3(texel, layer), 0) * 255.0;
    vec4 values = (levels - 128.0) / 127.0;
    for (int i = 0; i < 4 && 4 * layer + i < 25; i++) {
      sum += values[i] * uTransferScale[4 * layer + i] * uLight[4 * layer + i];
    }
  }
  return sum;
}

// The split sum (r3gw.rendering.cook_torrance).
vec3 specular(vec3 normal, vec3 toCamera, float roughness) {
  float cosine = dot(normal, toCamera);
  float y[25];
  shBasis(2.0 * cosine * normal - toCamera, y);
  vec3 radiance = vec3(0.0);
  for (int l = 0; l <= 4; l++) {
    float smoothing = exp(-float(l * (l + 1)) * roughness * roughness);
    for (int i = l * l; i < (l + 1) * (l + 1); i++) radiance += smoothing * y[i] * uLight[i];
  }
  float root = sqrt(clamp(cosine, ${float(c.smallestCosine)}, 1.0));
  vec2 at = (vec2(roughness, root) * (uTableSize - 1.0) + 0.5) / uTableSize;
  vec2 f = textureLod(uTable, at, 0.0).rg;
  return max(radiance, ${float(c.darkestSpecular)}) * (${float(c.dielectricF0)} * f.x + f.y);
}

vec3 surfaceColour(ivec2 texel, vec3 centre, vec3 axis) {
  vec4 stored = texelFetch(uSurface, texel, 0);
  vec3 albedo = pow(stored.rgb, vec3(${float(c.gamma)}));
  vec3 toCamera = normalize(uEye - centre);
  vec3 normal = dot(axis, toCamera) < 0.0 ? -axis : axis;
  if (uShow == 1) return displayFromLinear(albedo);
  if (uShow == 2) return 0.5 * normal + 0.5;
  if (uShow == 4) return vec3(stored.a);
  if (uShow == 5) albedo = vec3(0.8);
  vec3 arriving = irradiance(normal);
  if (uWithShadows) arriving += shadowed(texel);
  vec3 linear = albedo / 3.14159265358979 * arriving;
  if (uWithSpecular && uShow != 5) linear += specular(normal, toCamera, stored.a);
  return toned(linear);
}

vec3 depthColour(vec3 centre) {
  float depth = dot(centre - uEye, uForward);
  return vec3(1.0 - clamp((depth - uDepthRange.x) / (uDepthRange.y - uDepthRange.x), 0.0, 1.0));
}

void sceneSplat(int index, inout Gsplat splat) {
  ivec2 texel = ivec2(index & 2047, index >> 11);
  vec4 place = texelFetch(uPlace, texel, 0);
  uvec4 shape = texelFetch(uShape, texel, 0);
  bool isForeground = index < uNumForeground;
  splat.flags = (isForeground ? uForegroundShown : uSkyShown) ? GSPLAT_FLAG_ACTIVE : 0u;
  splat.index = index;
  splat.center = place.xyz;
  splat.quaternion = normalize(vec4(unpackSnorm2x16(shape.x), unpackSnorm2x16(shape.y)));
  splat.scales = exp(vec3(unpackHalf2x16(shape.z), unpackHalf2x16(shape.w).x));
  vec3 colour;
  if (uShow == 3) {
    colour = depthColour(place.xyz);
  } else if (isForeground) {
    colour = surfaceColour(texel, place.xyz, quatVec(splat.quaternion, vec3(0.0, 0.0, 1.0)));
  } else {
    colour = skySeen(normalize(place.xyz - uEye));
  }
  splat.rgba = vec4(colour, place.w);
}
`;var WIDTH=2048,TRANSFER_LAYERS=7;async function makeSplats(payload,uniforms){let{rows}=payload,place=new Float32Array((await blob("place")).buffer),shape=new Uint32Array((await blob("shape")).buffer),surface=await blob("surface"),table=new Uint16Array((await blob("table")).buffer),textures={uPlace:texture(place,WIDTH,rows,THREE4.RGBAFormat,THREE4.FloatType),uShape:texture(shape,WIDTH,rows,THREE4.RGBAIntegerFormat,THREE4.UnsignedIntType),uSurface:texture(surface,WIDTH,rows,THREE4.RGBAFormat,THREE4.UnsignedByteType),uTransfer:await transfer(rows),uTable:texture(table,payload.tableSize,payload.tableSize,THREE4.RGFormat,THREE4.HalfFloatType)};textures.uShape.internalFormat="RGBA32UI",textures.uTable.minFilter=textures.uTable.magFilter=THREE4.LinearFilter;let all={...uniforms};for(let[name,value]of Object.entries(textures))all[name]={value};let generator=new import_spark.dyno.Dyno({inTypes:{index:"int"},outTypes:{gsplat:import_spark.dyno.Gsplat},generate:({inputs,outputs})=>({globals:[import_spark.dyno.defineGsplat,skySource(payload.constants)+splatSource(payload.constants)],statements:[`sceneSplat(${inputs.index}, ${outputs.gsplat});`],uniforms:all})});return new import_spark.SplatGenerator({numSplats:payload.numForeground+payload.numSky,generator,update:({camera})=>{camera&&(camera.getWorldPosition(uniforms.uEye.value),camera.getWorldDirection(uniforms.uForward.value))}})}async function transfer(rows){let isPresent=hasBlob("transfer"),values=isPresent?await blob("transfer"):new Uint8Array(4*TRANSFER_LAYERS),[width,height]=isPresent?[WIDTH,rows]:[1,1],array2=new THREE4.DataArrayTexture(values,width,height,TRANSFER_LAYERS);return array2.needsUpdate=!0,array2}function texture(data,width,height,format,type){let made=new THREE4.DataTexture(data,width,height,format,type);return made.needsUpdate=!0,made}var import_spark2=__require("@sparkjsdev/spark"),THREE5=__toESM(__require("three"),1);var LARGEST_RADIUS_PX=8192,SKY_RAY=`
uniform mat3 uRayFromNdc;
vec3 skyAt(vec2 ndc) { return skySeen(normalize(uRayFromNdc * vec3(ndc, 1.0))); }
`,Stage=class{constructor(canvas,splats,uniforms,constants){this.splats=splats;this.uniforms=uniforms;this.renderer=new THREE5.WebGLRenderer({canvas,antialias:!1,alpha:!0}),this.renderer.setClearColor(0,0),this.camera.up.set(0,-1,0),this.spark=new import_spark2.SparkRenderer({renderer:this.renderer,onDirty:()=>this.request(),accumExtSplats:!0,sortRadial:!1,maxStdDev:Math.sqrt(-2*Math.log(constants.minAlpha)),minAlpha:constants.minAlpha,preBlurAmount:constants.lowPassPx2,blurAmount:0,clipXY:Number.MAX_VALUE,maxPixelRadius:LARGEST_RADIUS_PX,enableLod:!1,extraUniforms:uniforms,transparent:!0,depthTest:!1}),this.spark.renderOrder=1,adapt(this.spark.material,constants),this.scene.add(this.spark,splats,skyQuad(uniforms,constants))}splats;uniforms;renderer;camera=new THREE5.PerspectiveCamera;spark;onFrame=()=>{};scene=new THREE5.Scene;isRequested=!1;lastDrawn=0;setSize(width,height){this.renderer.setDrawingBufferSize(width,height,1),this.request()}recolour(){this.splats.updateVersion(),this.request()}request(){this.isRequested||(this.isRequested=!0,requestAnimationFrame(()=>{this.isRequested=!1,this.draw()}))}draw(){let{camera}=this;camera.updateMatrixWorld();let rotation=new THREE5.Matrix3().setFromMatrix4(camera.matrixWorld),p=camera.projectionMatrix.elements,ray=new THREE5.Matrix3().set(1/p[0],0,p[8]/p[0],0,1/p[5],p[9]/p[5],0,0,-1);this.uniforms.uRayFromNdc.value.copy(rotation.multiply(ray)),this.renderer.render(this.scene,camera);let now=performance.now();this.onFrame(now-this.lastDrawn),this.lastDrawn=now}async settle(){for(this.splats.updateVersion(),this.camera.updateMatrixWorld(),await this.spark.update({scene:this.scene,camera:this.camera});this.spark.sorting||this.spark.sortDirty;)await new Promise(resolve=>setTimeout(resolve,5));this.draw()}};function skyQuad(uniforms,constants){let geometry=new THREE5.BufferGeometry,corners=new Float32Array([-1,-1,0,3,-1,0,-1,3,0]);geometry.setAttribute("position",new THREE5.BufferAttribute(corners,3));let material=new THREE5.ShaderMaterial({glslVersion:THREE5.GLSL3,uniforms,depthTest:!1,depthWrite:!1,transparent:!0,blending:THREE5.NoBlending,vertexShader:`
      out vec2 vNdc;
      void main() { vNdc = position.xy; gl_Position = vec4(position.xy, 0.0, 1.0); }`,fragmentShader:`
      precision highp float;
      in vec2 vNdc;
      out vec4 fragColor;
      ${skySource(constants)}${SKY_RAY}
      void main() { fragColor = uSky == 3 ? vec4(0.0) : vec4(skyAt(vNdc), 1.0); }`}),quad=new THREE5.Mesh(geometry,material);return quad.frustumCulled=!1,quad.renderOrder=0,quad}function adapt(material,c){let reach=(1+2*c.frustumMargin).toFixed(6);material.vertexShader=replaced(material.vertexShader,"vec2 J2 = -(J1 * viewCenter.xy) * invZ;",`vec2 middle = vec2(projectionMatrix[2][0], projectionMatrix[2][1]);
        vec2 widen = 1.0 / vec2(projectionMatrix[0][0], projectionMatrix[1][1]);
        vec2 slope = clamp(-viewCenter.xy * invZ, (middle - ${reach}) * widen,
          (middle + ${reach}) * widen);
        vec2 J2 = J1 * slope;`);let sky=`uniform int uNumForeground;
uniform bool uSkyPerPixel;
${skySource(c)}${SKY_RAY}
void main() {`,fragment=replaced(material.fragmentShader,"void main() {",sky);fragment=replaced(fragment,"if (encodeLinear) {",`rgba.a = min(rgba.a, ${c.maxAlpha});
    if (uSkyPerPixel && int(vSplatIndex) >= uNumForeground) rgba.rgb = skyAt(vNdc.xy);
    if (encodeLinear) {`),material.fragmentShader=fragment}function replaced(text,part,by){if(text.split(part).length!==2)throw new Error(`Spark's shader is not the one of its pinned version: it lacks "${part}"`);return text.replace(part,by)}async function start(){let payload=await jsonBlob("payload"),uniforms=makeUniforms(payload),splats=await makeSplats(payload,uniforms),canvas=document.querySelector("#canvas"),stage=new Stage(canvas,splats,uniforms,payload.constants),lights=new Lights(payload,uniforms),first=payload.photos[0],lens=lensOf(first),api={payload,stage,lights,uniforms,async picture(state,photo,width,height){let found=payload.photos.find(p=>p.name===photo);lens=lensOf(found);let pose=poseOf(found);return stage.camera.position.copy(pose.position),stage.camera.quaternion.copy(pose.quaternion),stage.renderer.setDrawingBufferSize(width,height,1),project(stage.camera,lens,width/height,payload.constants.nearPlane,1e4),lights.apply(state),await stage.settle(),canvas.toDataURL("image/png")},async drop(file){lights.dropped=await readMap(file,payload.constants.gamma)}};globalThis.r3gw=api,stage.request()}start();})();
};
"use strict";(()=>{var pause=()=>new Promise(resolve=>setTimeout(resolve,0));async function blob(id){let element=document.getElementById(id);if(!element)throw new Error(`this page lacks its part "${id}"`);let text=(element.textContent??"").trim();element.textContent="";let parts=[];for(let start=0;start<text.length;start+=262144)parts.push(bytesOf(text.slice(start,start+262144))),await pause();let stream=new Blob(parts).stream().pipeThrough(new DecompressionStream("deflate"));return new Uint8Array(await new Response(stream).arrayBuffer())}function bytesOf(base64){let binary=atob(base64),bytes=new Uint8Array(binary.length);for(let i=0;i<binary.length;i++)bytes[i]=binary.charCodeAt(i);return bytes}var shared=globalThis;async function boot(){let code=new Blob([await blob("libraries")],{type:"text/javascript"}),url=URL.createObjectURL(code);await new Promise((resolve,reject)=>{let script=document.createElement("script");script.src=url,script.onload=()=>resolve(),script.onerror=()=>reject(new Error("the page's libraries do not run")),document.head.append(script)}),URL.revokeObjectURL(url),shared.r3gwPage(name=>shared.r3gwLibraries[name])}boot().catch(error=>{let message=document.getElementById("message");message&&(message.textContent=`This page could not start: ${String(error)}`),console.error(error)});})();
