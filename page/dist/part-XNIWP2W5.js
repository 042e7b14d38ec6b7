import{a}from"./part-5Q4MJIXW.js";import"./part-4OTJZBQC.js";import"./part-BJ4XVPCP.js";export{a as Stage};
