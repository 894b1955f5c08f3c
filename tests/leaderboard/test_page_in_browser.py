"""The page in a browser; skipped without one, unless FFGYM_REQUIRE_BROWSER=1, as on CI."""

import os
import shutil
from dataclasses import dataclass
from urllib.parse import quote

import pytest
from selenium import webdriver
from selenium.common.exceptions import WebDriverException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait

WIDTHS = (1280, 375)


@dataclass(frozen=True)
class Browser:
    """What a reader does with the page and sees of it."""

    driver: webdriver.Chrome
    url: str

    def open(self, width=1280, url=None):
        """The page, anew, in a window whose content is that wide."""
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False},
        )
        self.driver.get("about:blank")
        self.driver.get(url or self.url)
        # on a busy machine the driver may take the empty page for the one that it waits for
        ready = "return location.protocol !== 'about:' && document.readyState === 'complete'"
        WebDriverWait(self.driver, 30).until(lambda driver: driver.execute_script(ready))
        return self

    def column(self, key):
        """Text of every cell of a column, top to bottom."""
        script = "return [...document.querySelectorAll('#board tbody .' + arguments[0])].map(cell => cell.innerText)"
        return self.driver.execute_script(script, key)

    def numbers(self, key):
        """Numbers of a column; cells without one are left out."""
        firsts = [text.split()[0].replace(",", "") for text in self.column(key)]
        return [float(text) for text in firsts if text != "–"]

    def button(self, key):
        """What sorts a column, in the middle of the window."""
        button = self.driver.find_element(By.CSS_SELECTOR, f"#board thead button[data-key={key}]")
        self.driver.execute_script("arguments[0].scrollIntoView({ block: 'center', inline: 'center' })", button)
        return button

    def sorted_by(self):
        """Column that is sorted, and how."""
        found = self.driver.find_elements(By.CSS_SELECTOR, "#board th[aria-sort]")
        return [(th.get_attribute("class").split()[0], th.get_attribute("aria-sort")) for th in found]

    def find(self, selector):
        """First element of a CSS selector."""
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def overflow(self):
        """Pixels that the page is wider than its window."""
        script = "return document.documentElement.scrollWidth - document.documentElement.clientWidth"
        return self.driver.execute_script(script)


@pytest.fixture(scope="module")
def browser(board_page, tmp_path_factory):
    path = tmp_path_factory.mktemp("board") / "leader board.html"
    path.write_text(board_page, encoding="utf-8")
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    found = shutil.which("chromedriver")
    try:
        if found is None:
            raise WebDriverException("There is no chromedriver; install the packages chromium and chromium-driver.")
        driver = webdriver.Chrome(options=options, service=Service(found))
    except WebDriverException as error:
        if os.environ.get("FFGYM_REQUIRE_BROWSER") == "1":
            raise
        pytest.skip(f"no browser: {error.msg}")
    yield Browser(driver, f"file://{quote(str(path))}")
    driver.quit()


@pytest.fixture
def page(browser):
    return browser.open()


def test_the_page_makes_no_request_and_no_error(browser):
    browser.driver.get_log("performance")
    browser.driver.get_log("browser")
    browser.open()
    browser.button("left").click()
    for card in browser.driver.find_elements(By.CSS_SELECTOR, "details.card summary"):
        card.send_keys(Keys.ENTER)
    requests = [entry["message"] for entry in browser.driver.get_log("performance")]
    sent = [text for text in requests if '"Network.requestWillBeSent"' in text]
    assert not [text for text in sent if '"url":"http' in text or '"url":"ws' in text]
    assert len([text for text in sent if '"url":"file:' in text]) == 1  # the page itself
    assert browser.driver.get_log("browser") == []


def test_its_policy_forbids_connections(page):
    script = """
        const done = arguments[0];
        addEventListener("securitypolicyviolation", (event) => done(event.effectiveDirective));
        fetch("http://127.0.0.1:9/").catch(() => {});
    """
    assert page.driver.execute_async_script(script) == "connect-src"
    page.driver.get_log("browser")  # the violation, which was meant


def test_a_click_on_a_heading_sorts_and_another_one_turns_the_order(page):
    assert page.sorted_by() == [("rank", "ascending")]
    page.button("robot").click()
    page.button("speed10").click()
    assert page.sorted_by() == [("speed10", "ascending")]
    rising = page.numbers("speed10")
    assert rising == sorted(rising)
    page.button("speed10").click()
    assert page.sorted_by() == [("speed10", "descending")]
    assert page.numbers("speed10") == rising[::-1]


def test_every_column_sorts_and_what_has_no_figure_goes_last_either_way(page):
    script = """
        const keys = [...document.querySelectorAll("#board thead button")].map((button) => button.dataset.key);
        return keys.flatMap((key) => [1, 2].map(() => {
            document.querySelector(`#board button[data-key=${key}]`).click();
            const cells = [...document.querySelectorAll("#board tbody ." + key)].map((cell) => cell.innerText);
            return [key, document.querySelector("#board [aria-sort]").className.split(" ")[0], cells];
        }));
    """
    found = page.driver.execute_script(script)
    assert len(found) > 30
    for key, sorted_by, cells in found:
        assert sorted_by == key
        dashes = [text.startswith("–") for text in cells]
        assert dashes == sorted(dashes)


def test_the_keyboard_alone_sorts_and_keeps_its_place(page):
    page.button("left").send_keys(Keys.ENTER)
    assert page.sorted_by() == [("left", "ascending")]
    assert page.driver.switch_to.active_element.get_attribute("data-key") == "left"
    page.driver.switch_to.active_element.send_keys(Keys.SPACE)
    assert page.sorted_by() == [("left", "descending")]


def test_the_first_tab_leads_to_a_visible_link_past_the_headline(page):
    page.find("body").send_keys(Keys.TAB)
    focused = page.driver.switch_to.active_element
    assert focused.text == "Skip to the table"
    assert focused.rect["x"] >= 0
    focused.send_keys(Keys.ENTER)
    assert page.driver.switch_to.active_element.get_attribute("id") == "standings"


@pytest.mark.parametrize("width", WIDTHS)
def test_what_the_keyboard_reaches_is_not_beneath_the_columns_that_stay(browser, width):
    page = browser.open(width)
    script = """
        const agent = document.querySelector('#board thead .agent').getBoundingClientRect().right;
        document.querySelector('.wide').scrollLeft = 1e6;
        return [...document.querySelectorAll('#board thead button')].reverse()
            .filter(each => !['rank', 'agent'].includes(each.dataset.key))
            .map(each => { each.focus(); each.scrollIntoView({block: 'nearest', inline: 'nearest'});
                           return each.getBoundingClientRect().left - agent; });
    """
    assert min(page.driver.execute_script(script)) >= 0


def test_every_control_has_a_label_and_shows_its_focus(page):
    for control in page.driver.find_elements(By.CSS_SELECTOR, "#controls select, #controls input"):
        assert control.accessible_name
    page.find("#search").send_keys("")
    outline = page.driver.execute_script(
        "const s = document.getElementById('search'); s.focus(); return getComputedStyle(s).outlineWidth"
    )
    assert outline == "3px"


def test_plants_and_circles_change_the_figures_and_the_columns(page):
    before = page.column("left")
    Select(page.find("#plants")).select_by_value("nominal")
    assert page.column("left") != before
    assert "elastic feed-forward with the true parameters" in page.find("#board").text  # the oracle
    Select(page.find("#circles")).select_by_value("thesis")
    assert not page.driver.find_elements(By.CSS_SELECTOR, "#board th.speed70")
    assert "36 circles" in page.find("#note").text


def test_track_learning_and_search_narrow_the_rows(page):
    everything = len(page.column("agent"))
    Select(page.find("#knowledge")).select_by_visible_text("per task")
    assert len(page.column("agent")) == 2
    page.find("#controls button").click()
    Select(page.find("#track")).select_by_visible_text("with feedback")
    assert set(page.column("control")) == {"with feedback"}
    page.find("#controls button").click()
    Select(page.find("#learning")).select_by_value("0")
    fixed = page.column("agent")
    assert any("elastic feed-forward" in text for text in fixed)
    assert not any("TQC" in text for text in fixed)
    page.find("#controls button").click()
    page.find("#search").send_keys("lugre sac")
    assert [text.split("\n")[0] for text in page.column("agent")] == ["SAC on dynamic LuGre"]
    assert page.find("#count").text == f"1 of {everything} rows"


def test_channels_narrow_the_rows_and_are_told_in_the_table(page):
    Select(page.find("#channel")).select_by_visible_text("set-points")
    assert page.column("agent") == ["NARX network"]
    assert page.column("channel") == ["set-points +8 ms"]
    Select(page.find("#channel")).select_by_visible_text("torque")
    assert set(page.column("channel")) == {"torque"}


def test_enter_in_the_search_field_does_not_leave_the_page(page):
    page.find("#search").send_keys("elastic" + Keys.ENTER)
    assert page.driver.current_url == page.url
    assert page.find("#search").get_attribute("value") == "elastic"


def test_a_name_in_the_table_opens_its_card_again_and_again(page):
    link, card = page.find("#board a[href='#agent-tqc_elastic']"), page.find("#agent-tqc_elastic")
    assert card.get_attribute("open") is None
    for _ in range(2):
        link.send_keys(Keys.ENTER)
        WebDriverWait(page.driver, 5).until(lambda _: card.get_attribute("open") is not None)
        assert page.driver.switch_to.active_element.tag_name == "summary"
        page.driver.switch_to.active_element.send_keys(Keys.ENTER)
        assert card.get_attribute("open") is None


def test_an_address_with_a_card_opens_it(browser):
    browser.open(url=browser.url + "#agent-elastic")
    assert browser.find("#agent-elastic").get_attribute("open") is not None
    assert browser.find("#agent-elastic svg").is_displayed()


@pytest.mark.parametrize(("width", "shown"), [(390, "phone"), (1280, "desk")])
def test_the_picture_at_a_glance_fits_the_page(browser, width, shown):
    browser.open(width)
    for form in ("phone", "desk"):
        picture = browser.find(f".overview .{form} svg")
        assert picture.is_displayed() == (form == shown)
    rect = browser.find(f".overview .{shown} svg").rect
    assert 0 <= rect["x"] < rect["x"] + rect["width"] <= width
    assert rect["width"] > 0.7 * min(width, 980)


@pytest.mark.parametrize("width", WIDTHS)
def test_the_page_never_scrolls_sideways_but_its_table_does(browser, width):
    browser.open(width)
    browser.driver.execute_script("document.querySelectorAll('details').forEach(card => { card.open = true; })")
    assert browser.overflow() <= 0
    wide = "const w = document.querySelector('.wide'); w.scrollLeft = 400; return w.scrollLeft"
    assert browser.driver.execute_script(wide) == 400
    agent = browser.find("#board tbody .agent")
    assert 0 <= agent.rect["x"] < width / 2  # it stays while the others move
    assert agent.rect["width"] < width / 2


def test_without_javascript_the_table_is_there_and_no_dead_control(browser):
    browser.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        browser.open()
        assert "TQC on elastic feed-forward" in browser.find("#board").text
        assert not browser.find("#controls").is_displayed()
        assert not browser.driver.find_elements(By.CSS_SELECTOR, "#board button")
    finally:
        browser.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
