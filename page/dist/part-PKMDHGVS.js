import{a,b}from"./part-TJ4Q62JM.js";import"./part-BJ4XVPCP.js";export{b as prepare,a as renderer};
