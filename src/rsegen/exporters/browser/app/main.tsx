/* The page: edits a document of a server, or shows the maps that are frozen into it. */

import { render } from "preact";
import "./page.css";

render(<p>rsegen</p>, document.getElementById("page")!);
