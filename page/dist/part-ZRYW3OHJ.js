import{a}from"./part-IV2OFY2C.js";import"./part-VPXHMX4N.js";import"./part-BJ4XVPCP.js";export{a as Stage};
