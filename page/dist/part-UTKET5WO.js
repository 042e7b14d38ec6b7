import{a}from"./part-GSX26JXB.js";import"./part-TJ4Q62JM.js";import"./part-4OTJZBQC.js";import"./part-BJ4XVPCP.js";export{a as Stage};
