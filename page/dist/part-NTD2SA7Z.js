import{a}from"./part-2VSJN6WP.js";import"./part-VPXHMX4N.js";import"./part-ETSL54HM.js";export{a as Stage};
