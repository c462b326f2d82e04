import "./pages/shell/app.js";
