import{a as ae}from"./part-OWF3PLGY.js";import{a as G}from"./part-2L3S7ETU.js";import{o as Y}from"./part-4OTJZBQC.js";import{a as oe,c as R}from"./part-6GWDPOE2.js";import{L as ie,M as H,N as ne,U as re,V as M,X as se,Z as L,_ as P,d as K,e as Q,f as Z,h as c,i as z,j as $,k as ee,l as j,n as _,p as F,q as U,s as x,y as te}from"./part-BJ4XVPCP.js";L.line={worldUnits:{value:1},linewidth:{value:1},resolution:{value:new Z},dashOffset:{value:0},dashScale:{value:1},dashSize:{value:1},gapSize:{value:1}};P.line={uniforms:H.merge([L.common,L.fog,L.line]),vertexShader:`
		#include <common>
		#include <color_pars_vertex>
		#include <fog_pars_vertex>
		#include <logdepthbuf_pars_vertex>
		#include <clipping_planes_pars_vertex>

		uniform float linewidth;
		uniform vec2 resolution;

		attribute vec3 instanceStart;
		attribute vec3 instanceEnd;

		attribute vec3 instanceColorStart;
		attribute vec3 instanceColorEnd;

		#ifdef WORLD_UNITS

			varying vec4 worldPos;
			varying vec3 worldStart;
			varying vec3 worldEnd;

			#ifdef USE_DASH

				varying vec2 vUv;

			#endif

		#else

			varying vec2 vUv;

		#endif

		#ifdef USE_DASH

			uniform float dashScale;
			attribute float instanceDistanceStart;
			attribute float instanceDistanceEnd;
			varying float vLineDistance;

		#endif

		float trimSegmentAlpha( const in vec4 start, const in vec4 end ) {

			// compute the interpolation factor needed to trim the segment so it terminates
			// between the camera plane and the near plane

			// conservative estimate of the near plane
			float a = projectionMatrix[ 2 ][ 2 ]; // 3nd entry in 3th column
			float b = projectionMatrix[ 3 ][ 2 ]; // 3nd entry in 4th column

			// we need different nearEstimate formula for reversed and default depth buffer
			// a is positive with a reversed depth buffer so it can be used for controlling the code flow
			float nearEstimate = ( a > 0.0 ) ? ( - b / ( a + 1.0 ) ) : ( - 0.5 * b / a );

			return ( nearEstimate - start.z ) / ( end.z - start.z );

		}

		void main() {

			#ifdef USE_COLOR

				vColor.xyz = ( position.y < 0.5 ) ? instanceColorStart : instanceColorEnd;

			#endif

			float aspect = resolution.x / resolution.y;

			// camera space
			vec4 start = modelViewMatrix * vec4( instanceStart, 1.0 );
			vec4 end = modelViewMatrix * vec4( instanceEnd, 1.0 );

			#ifdef USE_DASH

				float lineDistanceStart = dashScale * instanceDistanceStart;
				float lineDistanceEnd = dashScale * instanceDistanceEnd;

			#endif

			#ifdef WORLD_UNITS

				worldStart = start.xyz;
				worldEnd = end.xyz;

			#else

				vUv = uv;

			#endif

			// special case for perspective projection, and segments that terminate either in, or behind, the camera plane
			// clearly the gpu firmware has a way of addressing this issue when projecting into ndc space
			// but we need to perform ndc-space calculations in the shader, so we must address this issue directly
			// perhaps there is a more elegant solution -- WestLangley

			bool perspective = ( projectionMatrix[ 2 ][ 3 ] == - 1.0 ); // 4th entry in the 3rd column

			if ( perspective ) {

				if ( start.z < 0.0 && end.z >= 0.0 ) {

					float alpha = trimSegmentAlpha( start, end );
					end.xyz = mix( start.xyz, end.xyz, alpha );

					#ifdef USE_DASH

						lineDistanceEnd = mix( lineDistanceStart, lineDistanceEnd, alpha );

					#endif

				} else if ( end.z < 0.0 && start.z >= 0.0 ) {

					float alpha = trimSegmentAlpha( end, start );
					start.xyz = mix( end.xyz, start.xyz, alpha );

					#ifdef USE_DASH

						lineDistanceStart = mix( lineDistanceEnd, lineDistanceStart, alpha );

					#endif

				}

			}

			#ifdef USE_DASH

				vLineDistance = ( position.y < 0.5 ) ? lineDistanceStart : lineDistanceEnd;
				vUv = uv;

			#endif

			// clip space
			vec4 clipStart = projectionMatrix * start;
			vec4 clipEnd = projectionMatrix * end;

			// ndc space
			vec3 ndcStart = clipStart.xyz / clipStart.w;
			vec3 ndcEnd = clipEnd.xyz / clipEnd.w;

			// direction
			vec2 dir = ndcEnd.xy - ndcStart.xy;

			// account for clip-space aspect ratio
			dir.x *= aspect;
			dir = normalize( dir );

			#ifdef WORLD_UNITS

				vec3 worldDir = normalize( end.xyz - start.xyz );
				vec3 tmpFwd = perspective ? normalize( mix( start.xyz, end.xyz, 0.5 ) ) : vec3( 0.0, 0.0, - 1.0 );
				vec3 worldUp = normalize( cross( worldDir, tmpFwd ) );
				vec3 worldFwd = cross( worldDir, worldUp );
				worldPos = position.y < 0.5 ? start: end;

				// height offset
				float hw = linewidth * 0.5;
				worldPos.xyz += position.x < 0.0 ? hw * worldUp : - hw * worldUp;

				// don't extend the line if we're rendering dashes because we
				// won't be rendering the endcaps
				#ifndef USE_DASH

					// cap extension
					worldPos.xyz += position.y < 0.5 ? - hw * worldDir : hw * worldDir;

					// add width to the box
					worldPos.xyz += worldFwd * hw;

					// endcaps
					if ( position.y > 1.0 || position.y < 0.0 ) {

						worldPos.xyz -= worldFwd * 2.0 * hw;

					}

				#endif

				// project the worldpos
				vec4 clip = projectionMatrix * worldPos;

				// shift the depth of the projected points so the line
				// segments overlap neatly
				vec3 clipPose = ( position.y < 0.5 ) ? ndcStart : ndcEnd;

				// only shift the depth of vertices in front of the camera (#35137)
				if ( clip.w > 0.0 ) clip.z = clipPose.z * clip.w;

			#else

				vec2 offset = vec2( dir.y, - dir.x );
				// undo aspect ratio adjustment
				dir.x /= aspect;
				offset.x /= aspect;

				// sign flip
				if ( position.x < 0.0 ) offset *= - 1.0;

				// endcaps
				if ( position.y < 0.0 ) {

					offset += - dir;

				} else if ( position.y > 1.0 ) {

					offset += dir;

				}

				// adjust for linewidth
				offset *= linewidth;

				// adjust for clip-space to screen-space conversion // maybe resolution should be based on viewport ...
				offset /= resolution.y;

				// select end
				vec4 clip = ( position.y < 0.5 ) ? clipStart : clipEnd;

				// back to clip space
				offset *= clip.w;

				clip.xy += offset;

			#endif

			gl_Position = clip;

			vec4 mvPosition = ( position.y < 0.5 ) ? start : end; // this is an approximation

			#include <logdepthbuf_vertex>
			#include <clipping_planes_vertex>
			#include <fog_vertex>

		}
		`,fragmentShader:`
		uniform vec3 diffuse;
		uniform float opacity;
		uniform float linewidth;

		#ifdef USE_DASH

			uniform float dashOffset;
			uniform float dashSize;
			uniform float gapSize;

		#endif

		varying float vLineDistance;

		#ifdef WORLD_UNITS

			varying vec4 worldPos;
			varying vec3 worldStart;
			varying vec3 worldEnd;

			#ifdef USE_DASH

				varying vec2 vUv;

			#endif

		#else

			varying vec2 vUv;

		#endif

		#include <common>
		#include <color_pars_fragment>
		#include <fog_pars_fragment>
		#include <logdepthbuf_pars_fragment>
		#include <clipping_planes_pars_fragment>

		vec2 closestLineToLine(vec3 p1, vec3 p2, vec3 p3, vec3 p4) {

			float mua;
			float mub;

			vec3 p13 = p1 - p3;
			vec3 p43 = p4 - p3;

			vec3 p21 = p2 - p1;

			float d1343 = dot( p13, p43 );
			float d4321 = dot( p43, p21 );
			float d1321 = dot( p13, p21 );
			float d4343 = dot( p43, p43 );
			float d2121 = dot( p21, p21 );

			float denom = d2121 * d4343 - d4321 * d4321;

			float numer = d1343 * d4321 - d1321 * d4343;

			mua = numer / denom;
			mua = clamp( mua, 0.0, 1.0 );
			mub = ( d1343 + d4321 * ( mua ) ) / d4343;
			mub = clamp( mub, 0.0, 1.0 );

			return vec2( mua, mub );

		}

		void main() {

			float alpha = opacity;
			vec4 diffuseColor = vec4( diffuse, alpha );

			#include <clipping_planes_fragment>

			#ifdef USE_DASH

				if ( vUv.y < - 1.0 || vUv.y > 1.0 ) discard; // discard endcaps

				if ( mod( vLineDistance + dashOffset, dashSize + gapSize ) > dashSize ) discard; // todo - FIX

			#endif

			#ifdef WORLD_UNITS

				float len;

				if ( isOrthographic ) {

					// View rays are parallel to the z axis so the distance reduces to camera-space XY
					vec2 lineDir = worldEnd.xy - worldStart.xy;
					float t = clamp( dot( worldPos.xy - worldStart.xy, lineDir ) / dot( lineDir, lineDir ), 0.0, 1.0 );
					len = length( worldStart.xy + lineDir * t - worldPos.xy );

				} else {

					// Find the closest points on the view ray and the line segment
					vec3 rayEnd = normalize( worldPos.xyz ) * 1e5;
					vec3 lineDir = worldEnd - worldStart;
					vec2 params = closestLineToLine( worldStart, worldEnd, vec3( 0.0, 0.0, 0.0 ), rayEnd );

					vec3 p1 = worldStart + lineDir * params.x;
					vec3 p2 = rayEnd * params.y;
					vec3 delta = p1 - p2;
					len = length( delta );

				}

				float norm = len / linewidth;

				#ifndef USE_DASH

					#ifdef USE_ALPHA_TO_COVERAGE

						float dnorm = fwidth( norm );
						alpha = 1.0 - smoothstep( 0.5 - dnorm, 0.5 + dnorm, norm );

					#else

						if ( norm > 0.5 ) {

							discard;

						}

					#endif

				#endif

			#else

				#ifdef USE_ALPHA_TO_COVERAGE

					// artifacts appear on some hardware if a derivative is taken within a conditional
					float a = vUv.x;
					float b = ( vUv.y > 0.0 ) ? vUv.y - 1.0 : vUv.y + 1.0;
					float len2 = a * a + b * b;
					float dlen = fwidth( len2 );

					if ( abs( vUv.y ) > 1.0 ) {

						alpha = 1.0 - smoothstep( 1.0 - dlen, 1.0 + dlen, len2 );

					}

				#else

					if ( abs( vUv.y ) > 1.0 ) {

						float a = vUv.x;
						float b = ( vUv.y > 0.0 ) ? vUv.y - 1.0 : vUv.y + 1.0;
						float len2 = a * a + b * b;

						if ( len2 > 1.0 ) discard;

					}

				#endif

			#endif

			#include <logdepthbuf_fragment>
			#include <color_fragment>

			gl_FragColor = vec4( diffuseColor.rgb, alpha );

			#include <tonemapping_fragment>
			#include <colorspace_fragment>
			#include <fog_fragment>
			#include <premultiplied_alpha_fragment>

		}
		`};var B=class extends ne{constructor(e){super({type:"LineMaterial",uniforms:H.clone(P.line.uniforms),vertexShader:P.line.vertexShader,fragmentShader:P.line.fragmentShader,clipping:!0}),this.isLineMaterial=!0,this.setValues(e)}get color(){return this.uniforms.diffuse.value}set color(e){this.uniforms.diffuse.value=e}get worldUnits(){return"WORLD_UNITS"in this.defines}set worldUnits(e){e===!0!==this.worldUnits&&(this.needsUpdate=!0),e===!0?this.defines.WORLD_UNITS="":delete this.defines.WORLD_UNITS}get linewidth(){return this.uniforms.linewidth.value}set linewidth(e){this.uniforms.linewidth&&(this.uniforms.linewidth.value=e)}get dashed(){return"USE_DASH"in this.defines}set dashed(e){e===!0!==this.dashed&&(this.needsUpdate=!0),e===!0?this.defines.USE_DASH="":delete this.defines.USE_DASH}get dashScale(){return this.uniforms.dashScale.value}set dashScale(e){this.uniforms.dashScale.value=e}get dashSize(){return this.uniforms.dashSize.value}set dashSize(e){this.uniforms.dashSize.value=e}get dashOffset(){return this.uniforms.dashOffset.value}set dashOffset(e){this.uniforms.dashOffset.value=e}get gapSize(){return this.uniforms.gapSize.value}set gapSize(e){this.uniforms.gapSize.value=e}get opacity(){return this.uniforms.opacity.value}set opacity(e){this.uniforms&&(this.uniforms.opacity.value=e)}get resolution(){return this.uniforms.resolution.value}set resolution(e){this.uniforms.resolution.value.copy(e)}get alphaToCoverage(){return"USE_ALPHA_TO_COVERAGE"in this.defines}set alphaToCoverage(e){this.defines&&(e===!0!==this.alphaToCoverage&&(this.needsUpdate=!0),e===!0?this.defines.USE_ALPHA_TO_COVERAGE="":delete this.defines.USE_ALPHA_TO_COVERAGE)}};var le=new _,T=new c,D=class extends re{constructor(){super(),this.isLineSegmentsGeometry=!0,this.type="LineSegmentsGeometry";let e=[-1,2,0,1,2,0,-1,1,0,1,1,0,-1,0,0,1,0,0,-1,-1,0,1,-1,0],t=[-1,2,1,2,-1,1,1,1,-1,-1,1,-1,-1,-2,1,-2],i=[0,2,1,2,3,1,2,4,3,4,5,3,4,6,5,6,7,5];this.setIndex(i),this.setAttribute("position",new F(e,3)),this.setAttribute("uv",new F(t,2))}applyMatrix4(e){let t=this.attributes.instanceStart,i=this.attributes.instanceEnd;return t!==void 0&&(t.applyMatrix4(e),i.applyMatrix4(e),t.needsUpdate=!0),this.boundingBox!==null&&this.computeBoundingBox(),this.boundingSphere!==null&&this.computeBoundingSphere(),this}setPositions(e){let t;e instanceof Float32Array?t=e:Array.isArray(e)&&(t=new Float32Array(e));let i=new M(t,6,1);return this.setAttribute("instanceStart",new x(i,3,0)),this.setAttribute("instanceEnd",new x(i,3,3)),this.instanceCount=this.attributes.instanceStart.count,this.computeBoundingBox(),this.computeBoundingSphere(),this}setColors(e){let t;e instanceof Float32Array?t=e:Array.isArray(e)&&(t=new Float32Array(e));let i=new M(t,6,1);return this.setAttribute("instanceColorStart",new x(i,3,0)),this.setAttribute("instanceColorEnd",new x(i,3,3)),this}fromWireframeGeometry(e){return this.setPositions(e.attributes.position.array),this}fromEdgesGeometry(e){return this.setPositions(e.attributes.position.array),this}fromMesh(e){return this.fromWireframeGeometry(new ie(e.geometry)),this}fromLineSegments(e){let t=e.geometry;return this.setPositions(t.attributes.position.array),this}computeBoundingBox(){this.boundingBox===null&&(this.boundingBox=new _);let e=this.attributes.instanceStart,t=this.attributes.instanceEnd;e!==void 0&&t!==void 0&&(this.boundingBox.setFromBufferAttribute(e),le.setFromBufferAttribute(t),this.boundingBox.union(le))}computeBoundingSphere(){this.boundingSphere===null&&(this.boundingSphere=new U),this.boundingBox===null&&this.computeBoundingBox();let e=this.attributes.instanceStart,t=this.attributes.instanceEnd;if(e!==void 0&&t!==void 0){let i=this.boundingSphere.center;this.boundingBox.getCenter(i);let r=0;for(let s=0,o=e.count;s<o;s++)T.fromBufferAttribute(e,s),r=Math.max(r,i.distanceToSquared(T)),T.fromBufferAttribute(t,s),r=Math.max(r,i.distanceToSquared(T));this.boundingSphere.radius=Math.sqrt(r),isNaN(this.boundingSphere.radius)&&console.error("THREE.LineSegmentsGeometry.computeBoundingSphere(): Computed radius is NaN. The instanced position data is likely to have NaN values.",this)}}toJSON(){}};var N=new z,de=new c,ce=new c,u=new z,p=new z,v=new z,V=new c,k=new $,h=new se,fe=new c,C=new _,O=new U,y=new z,w,E;function ue(a,e,t){return y.set(0,0,-e,1).applyMatrix4(a.projectionMatrix),y.multiplyScalar(1/y.w),y.x=E/t.width,y.y=E/t.height,y.applyMatrix4(a.projectionMatrixInverse),y.multiplyScalar(1/y.w),Math.abs(Math.max(y.x,y.y))}function ve(a,e){let t=a.matrixWorld,i=a.geometry,r=i.attributes.instanceStart,s=i.attributes.instanceEnd,o=Math.min(i.instanceCount,r.count);for(let n=0,l=o;n<l;n++){h.start.fromBufferAttribute(r,n),h.end.fromBufferAttribute(s,n),h.applyMatrix4(t);let d=new c,f=new c;w.distanceSqToSegment(h.start,h.end,f,d),f.distanceTo(d)<E*.5&&e.push({point:f,pointOnLine:d,distance:w.origin.distanceTo(f),object:a,face:null,faceIndex:n,uv:null,uv1:null})}}function ye(a,e,t){let i=e.projectionMatrix,s=a.material.resolution,o=a.matrixWorld,n=a.geometry,l=n.attributes.instanceStart,d=n.attributes.instanceEnd,f=Math.min(n.instanceCount,l.count),m=-e.near;w.at(1,v),v.w=1,v.applyMatrix4(e.matrixWorldInverse),v.applyMatrix4(i),v.multiplyScalar(1/v.w),v.x*=s.x/2,v.y*=s.y/2,v.z=0,V.copy(v),k.multiplyMatrices(e.matrixWorldInverse,o);for(let g=0,S=f;g<S;g++){if(u.fromBufferAttribute(l,g),p.fromBufferAttribute(d,g),u.w=1,p.w=1,u.applyMatrix4(k),p.applyMatrix4(k),u.z>m&&p.z>m)continue;if(u.z>m){let A=u.z-p.z,b=(u.z-m)/A;u.lerp(p,b)}else if(p.z>m){let A=p.z-u.z,b=(p.z-m)/A;p.lerp(u,b)}u.applyMatrix4(i),p.applyMatrix4(i),u.multiplyScalar(1/u.w),p.multiplyScalar(1/p.w),u.x*=s.x/2,u.y*=s.y/2,p.x*=s.x/2,p.y*=s.y/2,h.start.copy(u),h.start.z=0,h.end.copy(p),h.end.z=0;let X=h.closestPointToPointParameter(V,!0);h.at(X,fe);let J=Q.lerp(u.z,p.z,X),he=J>=-1&&J<=1,me=V.distanceTo(fe)<E*.5;if(he&&me){h.start.fromBufferAttribute(l,g),h.end.fromBufferAttribute(d,g),h.start.applyMatrix4(o),h.end.applyMatrix4(o);let A=new c,b=new c;w.distanceSqToSegment(h.start,h.end,b,A),t.push({point:b,pointOnLine:A,distance:w.origin.distanceTo(b),object:a,face:null,faceIndex:g,uv:null,uv1:null})}}}var W=class extends te{constructor(e=new D,t=new B({color:Math.random()*16777215})){super(e,t),this.isLineSegments2=!0,this.type="LineSegments2"}computeLineDistances(){let e=this.geometry,t=e.attributes.instanceStart,i=e.attributes.instanceEnd,r=new Float32Array(2*t.count);for(let o=0,n=0,l=t.count;o<l;o++,n+=2)de.fromBufferAttribute(t,o),ce.fromBufferAttribute(i,o),r[n]=n===0?0:r[n-1],r[n+1]=r[n]+de.distanceTo(ce);let s=new M(r,2,1);return e.setAttribute("instanceDistanceStart",new x(s,1,0)),e.setAttribute("instanceDistanceEnd",new x(s,1,1)),this}raycast(e,t){let i=this.material.worldUnits,r=e.camera;if(r===null&&!i&&console.error('LineSegments2: "Raycaster.camera" needs to be set in order to raycast against LineSegments2 while worldUnits is set to false.'),i===!1&&(this.material.resolution.x===0||this.material.resolution.y===0))return;let s=e.params.Line2!==void 0&&e.params.Line2.threshold||0;w=e.ray;let o=this.matrixWorld,n=this.geometry,l=this.material;E=l.linewidth+s,n.boundingSphere===null&&n.computeBoundingSphere(),O.copy(n.boundingSphere).applyMatrix4(o);let d;if(i)d=E*.5;else{let m=Math.max(r.near,O.distanceToPoint(w.origin));d=ue(r,m,l.resolution)}if(O.radius+=d,w.intersectsSphere(O)===!1)return;n.boundingBox===null&&n.computeBoundingBox(),C.copy(n.boundingBox).applyMatrix4(o);let f;if(i)f=E*.5;else{let m=Math.max(r.near,C.distanceToPoint(w.origin));f=ue(r,m,l.resolution)}C.expandByScalar(f),w.intersectsBox(C)!==!1&&(i?ve(this,t):ye(this,r,t))}onBeforeRender(e){let t=this.material.uniforms;t&&t.resolution&&(e.getViewport(N),this.material.uniforms.resolution.value.set(N.z,N.w))}};var I=class{all=new ee;#e;#t;constructor(e,t){let i=e.slice(1).map((n,l)=>({from:e[l],to:n})),r=i.filter(({to:n})=>!n.rapid);this.#e=q(r,({before:n})=>G((n??0)/t),4),this.#t=q(r,({after:n})=>G((n??0)/t),4);let s=new j(Y("dim")),o=q(i.filter(({to:n})=>n.rapid),()=>[s.r,s.g,s.b],1);this.all.add(this.#e,this.#t,o)}show(e){this.#e.visible=e==="before",this.#t.visible=e==="after"}};function q(a,e,t){let i=new Float32Array(6*a.length),r=new Float32Array(6*a.length),s=new j;a.forEach(({from:l,to:d},f)=>{l.tip.toArray(i,6*f),d.tip.toArray(i,6*f+3),s.setRGB(...e(d),K),s.toArray(r,6*f),s.toArray(r,6*f+3)});let o=new D;i.length>0&&o.setPositions(i).setColors(r);let n=new W(o,new B({linewidth:t,vertexColors:!0}));return n.visible=i.length>0,n}var pe=class{constructor(e,t,i,r,s){this.stage=e;this.poses=t;this.way=i;let o=new c(...i.offset),n=new _().setFromPoints(t.filter(S=>!S.rapid).map(S=>S.tip));n.isEmpty()&&n.setFromPoints(t.map(S=>S.tip)),this.#i=n.translate(o).getBoundingSphere(new U);let l=oe(i.kinematics,"table").at(-1),d=l?.direction??new c(0,0,1),f=Math.min(...we(n).map(S=>S.sub(l?.point??new c).dot(d))),m=Math.max(this.#i.radius,s.radius,1),g=this.#i.center.clone().sub(l?.point??new c).projectOnPlane(d).length()+m;this.#e=new ae(i.kinematics,Math.max(g*1.1,m*1.3),f-m*.35,s),this.#t=new I(t,r),this.#t.all.position.copy(o),this.#e.table.add(this.#t.all),this.stage.scene.add(this.#e.all),this.stage.passes=()=>this.#r(),this.pose(0),this.fit()}stage;poses;way;#e;#t;#i;#n=.5;fit(){let e=this.poses[0],t=this.#i.clone();e&&t.applyMatrix4(R(this.way.kinematics,e.words)),t.radius*=1.75,this.stage.look(t)}pose(e){let t=this.poses[Math.round(e)];if(!t)return;let i=t.tip.clone().add(new c(...this.way.offset));this.#e.pose(t.words,i.applyMatrix4(R(this.way.kinematics,t.words))),this.stage.draw()}divide(e){this.#n=e,this.stage.draw()}#r(){let{renderer:e,scene:t,camera:i,width:r,height:s}=this.stage,o=Math.round(r*this.#n);e.setScissorTest(!0);for(let[n,l,d]of[["before",0,o],["after",o,r]])d<=l||(e.setScissor(l,0,d-l,s),this.#t.show(n),e.render(t,i))}end(){this.stage.passes=null,this.stage.scene.remove(this.#e.all)}};function we(a){let e=[a.min,a.max];return e.flatMap(t=>e.flatMap(i=>e.map(r=>new c(t.x,i.y,r.z))))}export{pe as PathScene};
