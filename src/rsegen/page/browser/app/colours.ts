/* Colours that mean the same in the 3D view and on the plan. */

export const ACCENT = "#e0218a"; // what is selected or about to be changed; the goal of a way
export const START = "#0b8f6a"; // of a way, and a way that gets across
export const TROUBLE = "#e8590c"; // what happens on a way, and a way that does not get across
export const GOOD = "#14a37f"; // a robot that stands and holds
export const BAD = "#e3263a"; // one that does not; what is erased
export const MARKS = { contact: "#8b95a1", trouble: BAD, success: GOOD }; // of what happened in a drive
export const TRAILS = ["#d6336c", "#1c7ed6", "#e8590c", "#5f3dc4", "#0b7285"]; // of robots that drive together
