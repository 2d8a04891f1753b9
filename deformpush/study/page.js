// Moves one k through the page: picture, marks on it, text, cursors of the charts, row of the table.
const run = JSON.parse(document.getElementById("run").textContent);
const slider = document.querySelector(".steer input");
const [back, play, on] = document.querySelectorAll(".steer button");
const at = (name) => document.getElementById(name);
// Milliseconds a push: a long run is played in about a minute and a half.
const pace = Math.max(40, Math.min(450, 90000 / run.last));
let timer = null;

function show(k) {
  k = Math.max(0, Math.min(run.last, k));
  slider.value = k;
  at("picture").setAttribute("href", "data:image/jpeg;base64," + run.pictures[k]);
  at("contour").setAttribute("points", run.contours[k]);
  at("trail").setAttribute("points", run.centroids.slice(0, k + 1).join(" "));
  const push = k < run.last ? run.paths[k + 1] : null;
  at("push").style.display = push ? "" : "none";
  if (push) {
    const [x, y, u, v] = push, length = Math.hypot(u - x, v - y) || 1;
    const a = ((u - x) / length) * 7, b = ((v - y) / length) * 7;
    at("arrow").setAttribute("d", `M${x} ${y}L${u} ${v}M${u - a - b * 0.6} ${v - b + a * 0.6}L${u} ${v}L${u - a + b * 0.6} ${v - b - a * 0.6}`);
    at("start").setAttribute("cx", x);
    at("start").setAttribute("cy", y);
  }
  at("text").innerHTML = run.texts[k];
  for (const cursor of document.querySelectorAll(".cursor")) {
    cursor.style.display = "block";
    cursor.style.left = (100 * k) / Math.max(run.last, 1) + "%";
  }
  document.querySelector("tr.now")?.classList.remove("now");
  at("row" + k)?.classList.add("now");
}

function pause() {
  clearInterval(timer);
  timer = null;
  play.textContent = "\u25b6";
}

slider.oninput = () => { pause(); show(+slider.value); };
back.onclick = () => { pause(); show(+slider.value - 1); };
on.onclick = () => { pause(); show(+slider.value + 1); };
play.onclick = () => {
  if (timer) return pause();
  if (+slider.value === run.last) show(0);
  play.textContent = "\u275a\u275a";
  timer = setInterval(() => (+slider.value < run.last ? show(+slider.value + 1) : pause()), pace);
};
for (const plot of document.querySelectorAll(".plot")) {
  const seek = (event) => {
    const box = plot.getBoundingClientRect();
    pause();
    show(Math.round(((event.clientX - box.left) / box.width) * run.last));
  };
  plot.onpointerdown = seek;
  plot.onpointermove = (event) => event.buttons && seek(event);
}
document.onkeydown = (event) => {
  if (event.target === slider) return;
  if (event.key === "ArrowLeft") show(+slider.value - 1);
  if (event.key === "ArrowRight") show(+slider.value + 1);
};
show(location.hash.startsWith("#k=") ? +location.hash.slice(3) : 0);
