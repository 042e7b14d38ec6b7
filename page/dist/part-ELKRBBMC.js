import{$ as f,W as a,X as b,Y as c,Z as d,_ as e,aa as g}from"./part-VHRKOZ6P.js";export{b as about,a as axesOf,g as fromZ,d as machineFromTable,c as motionOf,f as tipFromRam,e as tipOf};
