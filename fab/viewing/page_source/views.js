// What result pages and the studio draw with: bundled once with three.js, as the global `quadfoldViews`.

export * from "./arrays.js";
export * from "./drawings.js";
export * from "./form_view.js";
